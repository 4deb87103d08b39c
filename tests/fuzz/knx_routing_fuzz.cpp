#include <algorithm>
#include <cstdlib>

#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "networks/knx/line/discovery.h"
#include "networks/knx/line/routing.h"
#include "networks/knx/wire/cemi.h"
#include "support/memory/memory_transports.h"

namespace rubicon::fuzz::knx_routing_fuzz {

/// Input: datagrams on the routing socket, each behind its length (one byte); all of it once as an answer to a search.
/// A telegram that is under way meanwhile leaves, or expires; a router may hold it up.
FUZZ_TARGET(knx_routing) {
  using namespace rubicon;
  using namespace rubicon::networks::knx::line;
  using namespace rubicon::networks::knx::wire;
  VirtualScheduler time;
  transport::MemoryNet net(time);
  transport::MemoryTransports lines;
  lines.join(net, "10.77.0.1");
  int outcomes = 0, found = 0;
  Routing::Callbacks calls;
  calls.send = [](ByteView) { return Result<void>(); };
  calls.received = [](const Telegram& telegram) {
    if (telegram.destination == GroupAddress{} || telegram.payload.bytes.size() > kMaxPayload) std::abort();
  };
  calls.frame = [](ByteView, bool) {};
  calls.lost = [](const transport::Endpoint&, const RoutingLostMessage&) {};
  calls.changed = [] {};
  calls.failed = [](const Error&) { std::abort(); };
  Discovery discovery(time, lines, {{"10.77.0.1"}, {}}, [&](const DiscoveryResult& result) {
    for (const auto& server : result.servers)
      if (describe(server).empty()) std::abort();
    ++found;
  });
  calls.discovery = [&](const transport::Endpoint& from, ByteView frame) { discovery.receive(from, frame); };
  Routing routing(time, {IndividualAddress(0xfffa)}, calls);
  routing.up({"10.77.0.1", 49152});
  ByteView rest(data, size);
  discovery.receive({"10.77.0.2", 3671}, rest);
  while (!rest.empty()) {
    const auto length = std::min<std::size_t>(rest[0], rest.size() - 1);
    routing.receive({"10.77.0.2", 3671}, rest.subspan(1, length));
    rest = rest.subspan(1 + length);
    time.run_for(std::chrono::milliseconds(1));
  }
  Telegram telegram;
  telegram.destination = GroupAddress(1);
  telegram.payload = {{1}, true};
  routing.send(telegram, time.now() + std::chrono::minutes(5), [&](SendOutcome, std::string_view) { ++outcomes; });
  time.run_for(std::chrono::minutes(6));
  if (outcomes != 1 || found != 1) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::knx_routing_fuzz
