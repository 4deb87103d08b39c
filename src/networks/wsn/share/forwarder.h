#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "base/scheduler.h"
#include "transport/transports.h"

namespace rubicon::networks::wsn::share {

struct ForwarderOptions {
  transport::Endpoint listen{"127.0.0.1", 9002};  ///< by default the port of wsn.md 4.1, on loopback
  bool may_configure = false;                     ///< clients may send Config packets, which change the island's id
  /// The sink's island: a Config packet that sets this id changes nothing and is forwarded (the programs of the
  /// original begin with it, wsn.md 9.1).
  std::optional<std::uint16_t> island{};
  std::size_t clients = 64;  ///< connected at a time; further ones are disconnected
  /// Bytes that may wait for a slow client in addition to the system's buffer; a client that exceeds this is
  /// disconnected. At most ByteStream::kMaxQueued.
  std::size_t client_bytes = std::size_t{64} * 1024;
  Duration greeting_timeout = std::chrono::seconds(5);  ///< a client without greeting is disconnected after this
  /// A client's packet that waited for longer while the sink took no packets at all is discarded: the sink was away,
  /// and a command must not be executed an hour later. A busy sink is waited for.
  Duration packet_lifetime = std::chrono::seconds(20);
  unsigned max_bad_packets = 100;  ///< a client that sends this many in a row is disconnected

  friend bool operator==(const ForwarderOptions&, const ForwarderOptions&) = default;
};

/// Called in turns of the loop and from resume(). Only `failed` may destroy the forwarder. All but `packet` may be
/// empty.
struct ForwarderCallbacks {
  /// A client's packet (8 to 122 bytes). False: there is no room for it; the forwarder then stops reading from that
  /// client and offers the packet again in resume().
  std::function<bool(ByteView packet)> packet;
  /// The listener failed; open() may be called again. Clients stay connected.
  std::function<void(Error)> failed;
  /// As SinkCallbacks::note, but called at most once a minute for each subject.
  std::function<void(const std::string& subject, std::string_view text)> note;
};

/// Shares a sink with other programs: a server of the serial-forwarder protocol (wsn.md 4.3). Clients stay connected
/// when the sink is lost. Destroying it disconnects them.
///
/// Packets are passed on in order of arrival; clients whose packets have to wait take turns. Packets of a client that
/// disconnected are still passed on until they expire; at most `clients` such clients are kept.
class Forwarder {
 public:
  /// Scheduler and transports must outlive it.
  Forwarder(ForwarderOptions options, Scheduler& scheduler, transport::Transports& transports,
            ForwarderCallbacks callbacks);
  ~Forwarder();
  Forwarder(const Forwarder&) = delete;
  Forwarder& operator=(const Forwarder&) = delete;

  /// Listens; does nothing if it listens already. kBusy: the port is taken.
  Result<void> open();
  /// Sends a packet of the sink to all clients that completed the greeting. Packets that the protocol's length byte
  /// cannot express (wsn.md 4.1: 1 to 255 bytes) are discarded.
  void broadcast(ByteView packet);
  /// `packet` has room again: offers the packets that wait.
  void resume();
  /// The address it listens on, with the port the system chose; empty if it does not listen.
  transport::Endpoint local() const;
  /// Connected clients, with and without greeting.
  std::size_t clients() const;
  /// Counters by name (`[a-z-]+`), since the start except for `clients` (connected now): clients-total,
  /// packets-to-clients, packets-from-clients (accepted ones); discarded packets: dropped-bad-packets, dropped-config,
  /// dropped-expired; disconnected clients: dropped-slow-clients, dropped-strangers (other protocol), dropped-silent
  /// (no greeting), refused-clients (too many); dropped-gone: disconnected clients whose packets were discarded.
  std::map<std::string, std::uint64_t> counters() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::networks::wsn::share
