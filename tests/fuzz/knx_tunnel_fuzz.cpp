#include <cstdlib>

#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "networks/knx/line/tunnel.h"

namespace rubicon::fuzz::knx_tunnel_fuzz {

/// Input: one byte of choices, then events for a tunnel that is connected: a length byte and a frame of it; 255 moves
/// time, 254 sends a telegram, 253 reports an undelivered datagram. Nothing that a server says may do harm.
FUZZ_TARGET(knx_tunnel) {
  using namespace rubicon;
  using namespace rubicon::networks::knx::line;
  using namespace rubicon::networks::knx::wire;
  if (size < 1) return 0;
  VirtualScheduler time;
  TunnelCounters counters;
  int under_way = 0;
  bool ended = false;
  Tunnel::Callbacks calls;
  calls.transmit = [&](Tunnel::Path, ByteView frame) {
    if (!read_message(frame)) std::abort();
  };
  calls.up = [] {};
  calls.bus = [](bool) {};
  calls.received = [&](ByteView, std::optional<Tunnel::Outcome> outcome) { under_way -= outcome ? 1 : 0; };
  calls.finished = [&](Tunnel::Outcome) { --under_way; };
  calls.ended = [&](const Tunnel::End& end) {
    if (ended || end.why.empty()) std::abort();
    ended = true;
    under_way = 0;
  };
  Tunnel tunnel(time, {(data[0] & 1) != 0, {}, (data[0] & 2) != 0, std::nullopt}, counters, std::move(calls));
  tunnel.connect();
  tunnel.receive(*base::from_hex("0610020600140100080100000000000004 0411c8"));
  const auto cemi = *base::from_hex("1100bce000000a070300800c33");
  for (std::size_t at = 1; at < size;) {
    const std::size_t length = data[at++];
    if (length == 255) {
      time.run_for(std::chrono::milliseconds(700));
    } else if (length == 254 && tunnel.idle()) {
      ++under_way;
      tunnel.send(cemi);
    } else if (length == 253) {
      tunnel.undelivered();
    } else {
      const auto take = std::min(length, size - at);
      tunnel.receive(ByteView(data + at, take));
      at += take;
    }
    if (under_way < 0 || under_way > 1) std::abort();
    if (ended && tunnel.up()) std::abort();
  }
  time.run_for(std::chrono::minutes(5));
  if (under_way != 0) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::knx_tunnel_fuzz
