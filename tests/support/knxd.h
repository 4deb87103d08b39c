#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "support/private_network.h"
#include "support/process.h"

namespace rubicon::support {

/// A private network with one interface that groups go through, as knxd needs it: it takes the port of KNX on all
/// addresses, and the interface of the default route. The calling thread is in it.
class KnxNetwork {
 public:
  static constexpr auto kAddress = "10.77.0.1";

  KnxNetwork();

  bool entered() const { return reason_.empty(); }
  /// Why not: rights or a program are missing.
  const std::string& reason() const { return reason_; }

 private:
  support::PrivateNetwork network_;
  std::string reason_;
};

/// knxd (Debian's 0.14) without a bus: another implementation of KNXnet/IP, with knxtool as a user of its bus. Its name
/// is `test-knxd`, its address 1.1.250, those of its users 1.1.200 and up. Must be made in a KnxNetwork.
class Knxd {
 public:
  /// `routing`: it joins 224.0.23.12 and answers searches; then it passes 55 telegrams a second only. `users`: tunnels
  /// and programs that have room on its bus.
  explicit Knxd(bool routing = true, int users = 20);
  ~Knxd();
  Knxd(const Knxd&) = delete;
  Knxd& operator=(const Knxd&) = delete;

  /// It listens; asked until it does (0.2 s).
  bool ready() const;
  /// Without a word, as at SIGKILL; and starts it again.
  void kill();
  void restart();
  /// For knxtool.
  std::string url() const { return "local:" + folder_ + "/knx.sock"; }
  std::string errors() { return process_->errors(); }
  support::Process& process() { return *process_; }
  /// `knxtool COMMAND URL ARGUMENTS...`, to its end.
  support::Outcome tool(const std::string& command, std::vector<std::string> arguments) const;

 private:
  std::string folder_;
  bool routing_;
  std::unique_ptr<support::Process> process_;
};

/// `knxtool groupsocketlisten`: every group telegram on the bus of a knxd.
class KnxdListener {
 public:
  explicit KnxdListener(const Knxd& knxd);
  ~KnxdListener();
  KnxdListener(const KnxdListener&) = delete;
  KnxdListener& operator=(const KnxdListener&) = delete;

  /// All it wrote so far: lines like `Write from 1.1.205 to 1/2/4: 0C 33 `.
  std::string heard() const;

 private:
  std::string path_;
  std::unique_ptr<support::Process> process_;
};

}  // namespace rubicon::support
