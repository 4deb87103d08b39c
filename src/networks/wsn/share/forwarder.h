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
  transport::Endpoint listen{"127.0.0.1", 9002};  ///< the port of wsn.md 4.1, for this machine alone
  bool may_configure = false;                     ///< clients may send Config packets, which change the island's id
  /// The sink's island: a Config packet that sets this one changes nothing, and passes (the original's programs begin
  /// with it, wsn.md 9.1).
  std::optional<std::uint16_t> island{};
  std::size_t clients = 64;  ///< more are hung up on
  /// May wait for a slow client besides what the system holds for it; then it is hung up on. At most
  /// ByteStream::kMaxQueued.
  std::size_t client_bytes = std::size_t{64} * 1024;
  Duration greeting_time = std::chrono::seconds(5);  ///< who has not greeted by then is hung up on
  /// What had to wait for longer, while the sink took nothing of anybody, is dropped: a command to a sink that was away
  /// says nothing an hour later. A busy sink is waited for.
  Duration packet_life = std::chrono::seconds(20);
  unsigned bad_packets = 100;  ///< so many in a row, and the client is hung up on

  friend bool operator==(const ForwarderOptions&, const ForwarderOptions&) = default;
};

/// Called in turns of the loop and from room(). The forwarder may be destroyed in `failed` only. All but `packet` may
/// be empty.
struct ForwarderCallbacks {
  /// A client's packet (8 to 122 bytes). False: there is no room for it now; the forwarder keeps it, stops reading from
  /// that client and offers it again after room().
  std::function<bool(ByteView packet)> packet;
  /// The port is lost; open() may be called again. The clients stay.
  std::function<void(Error)> failed;
  /// As SinkCallbacks::note, but at most once a minute for a subject.
  std::function<void(const std::string& subject, std::string_view text)> note;
};

/// Shares a sink with other programs: a server of the serial-forwarder protocol (wsn.md 4.3). Clients stay when the
/// sink is lost. Destroyed = all are hung up on.
///
/// A packet that `packet` takes never overtakes one that had to wait, and clients whose packets wait take turns. What a
/// client said before it hung up still reaches the sink if its time allows; of such clients there may be as many as of
/// others.
class Forwarder {
 public:
  Forwarder(ForwarderOptions options, Scheduler& scheduler, transport::Transports& transports,
            ForwarderCallbacks calls);
  ~Forwarder();
  Forwarder(const Forwarder&) = delete;
  Forwarder& operator=(const Forwarder&) = delete;

  /// Listens; nothing if it does already. kBusy when the port is taken.
  Result<void> open();
  /// A packet of the sink, to every client that has greeted. One that no length byte can announce (wsn.md 4.1: 1 to 255
  /// bytes) is for nobody.
  void tell(ByteView packet);
  /// Packets are taken again.
  void room();
  /// The port the system chose; empty if it does not listen.
  transport::Endpoint local() const;
  /// Who is connected, greeted or not.
  std::size_t clients() const;
  /// Counters by name (`[a-z-]+`): clients (connected now), clients-total, packets-to-clients, packets-from-clients
  /// (that were taken), dropped-bad-packets, dropped-config, dropped-expired (packets), dropped-gone (clients that hung
  /// up before their packets were taken, and were too many), and of clients that were hung up on: dropped-slow-clients,
  /// dropped-strangers (who do not speak the protocol), dropped-silent, refused-clients (too many). All of them, from
  /// the start.
  std::map<std::string, std::uint64_t> counters() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::networks::wsn::share
