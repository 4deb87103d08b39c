#pragma once

#include <string>
#include <vector>

#include "support/meeting_folder.h"

namespace rubicon::ecology {

/// A network namespace with a loopback interface and a folder where programs meet: a host. Lives as long as the object
/// or a process in it.
class Host {
 public:
  Host();
  ~Host();
  Host(Host&& other) noexcept;
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  bool exists() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  /// Its name for the program `ip`.
  std::string name() const;

  /// While it lives, this process and those that it starts are on the host.
  class Visit {
   public:
    explicit Visit(const Host& host);
    ~Visit();
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;

   private:
    int former_ = -1;
    support::MeetingFolder folder_;
  };

  /// Packets that left through this interface so far.
  long packets_sent(const std::string& interface) const;

 private:
  int descriptor_ = -1;
  std::string folder_;
};

/// Virtual hosts that are connected to one switch, invisible outside of this program. Needs network namespaces (with a
/// user namespace if the user is not root) and the program `ip`; without them made() is false. The program stays in a
/// private network afterwards.
class Lan {
 public:
  explicit Lan(int hosts);

  bool made() const { return reason_.empty(); }
  /// The reason if made() is false.
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
  /// As DHCP or a roaming robot does: the former address is gone. Empty: there is none.
  void change_address(int host, const std::string& from, const std::string& to) const;

 private:
  bool connect();
  void port(int host, const std::string& state) const;

  std::string reason_;
  Host switch_;
  std::vector<Host> hosts_;
};

}  // namespace rubicon::ecology
