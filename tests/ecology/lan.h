#pragma once

#include <string>
#include <vector>

namespace rubicon::ecology {

/// A network namespace with nothing but a loopback that is up: what an operating system is to those who only look at
/// the network. Lives as long as the object or a process in it.
class Host {
 public:
  Host();
  ~Host();
  Host(Host&& other) noexcept;
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  bool exists() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  /// What the `ip` program calls it.
  std::string name() const;

  /// While it lives, this process and what it starts is on the host.
  class Visit {
   public:
    explicit Visit(const Host& host);
    ~Visit();
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;

   private:
    int former_ = -1;
  };

  /// Packets that left through this interface so far.
  long packets_sent(const std::string& interface) const;

 private:
  int descriptor_ = -1;
};

/// Hosts with a cable each to one switch, none of it real: nobody outside this program sees anything. Needs network
/// namespaces (of its own user's, if this user is not root) and the program `ip`; without them made() is false. A
/// program that made one stays in a network of its own.
class Lan {
 public:
  explicit Lan(int hosts);

  bool made() const { return reason_.empty(); }
  /// Why not.
  const std::string& reason() const { return reason_; }

  const Host& host(int number) const { return hosts_.at(static_cast<std::size_t>(number)); }
  static std::string address(int host) { return "10.77.0." + std::to_string(host + 1); }
  static constexpr const char* kCable = "cable";  ///< the interface of each host

  void unplug(int host) { port(host, "down"); }
  void plug_in(int host) { port(host, "up"); }
  void loopback_down(int host) const;
  void interface_down(int host) const;
  void interface_up(int host) const;
  void interface_without_multicast(int host) const;

 private:
  bool connect();
  void port(int host, const std::string& state) const;

  std::string reason_;
  Host switch_;
  std::vector<Host> hosts_;
};

}  // namespace rubicon::ecology
