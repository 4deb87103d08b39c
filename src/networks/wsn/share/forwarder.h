#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "transport/transports.h"

namespace rubicon::networks::wsn {

struct ForwarderOptions {
  transport::Endpoint listen{"127.0.0.1", 9002};      ///< the port of wsn.md 4.1, for this machine alone
  bool may_configure = false;                         ///< clients may send Config packets, which change the island's id
  std::size_t clients = 16;                           ///< more are hung up on
  std::size_t client_bytes = std::size_t{64} * 1024;  ///< may wait for a slow client; then it is hung up on
  Duration greeting_time = std::chrono::seconds(5);

  friend bool operator==(const ForwarderOptions&, const ForwarderOptions&) = default;
};

struct ForwarderCalls {
  /// A client's packet (8 to 122 bytes). False: there is no room for it now; the forwarder keeps it, stops reading from
  /// that client and offers it again after room().
  std::function<bool(ByteView packet)> packet;
  /// The port is lost; open() may be called again. The clients stay.
  std::function<void(Error)> failed;
  /// As SinkCalls::note.
  std::function<void(const std::string& subject, std::string_view text)> note;
};

/// Shares a sink with other programs: a server of the serial-forwarder protocol (wsn.md 4.3). Clients stay when the
/// sink is lost. Destroyed = all are hung up on.
class Forwarder {
 public:
  Forwarder(ForwarderOptions options, Scheduler& scheduler, transport::Transports& transports, ForwarderCalls calls);
  ~Forwarder();
  Forwarder(const Forwarder&) = delete;
  Forwarder& operator=(const Forwarder&) = delete;

  /// Listens; nothing if it does already. kBusy when the port is taken.
  Result<void> open();
  /// A packet of the sink, to every client that has greeted.
  void tell(ByteView packet);
  /// Packets are taken again.
  void room();
  /// The port the system chose; empty if it does not listen.
  transport::Endpoint local() const;
  std::size_t clients() const;
  /// Counters by name (`[a-z-]+`).
  std::map<std::string, std::uint64_t> counters() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rubicon::networks::wsn
