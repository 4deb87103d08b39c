#include "motes/rig.h"

#include <fmt/format.h>

#include "support/memory/memory_sinks.h"

namespace rubicon::bench::motes {

std::string island_of(const std::vector<std::uint16_t>& ports, const std::string& options) {
  auto text = fmt::format("island: {{id: {}, name: bench}}\nnetworks:\n", kIsland);
  int number = 0;
  for (const auto port : ports) {
    text += fmt::format("  wsn-{}: {{type: wsn, source: \"network@127.0.0.1:{}\", board: EM1000, {}}}\n", ++number,
                        port, options);
  }
  return text;
}

std::vector<std::uint16_t> ports_of(int sinks) {
  std::vector<std::uint16_t> ports;
  for (int i = 0; i < sinks; ++i) ports.push_back(static_cast<std::uint16_t>(kFirstPort + i));
  return ports;
}

bool reachable(island::Island& island, std::uint16_t sink, std::uint16_t mote) {
  const auto status = island.space().get(kIslandOwner, fmt::format("proxy.wsn-{}.{}.status", sink, mote));
  return status && status->value.find("\"reachable\"") != std::string_view::npos;
}

motes_simulator::WorldOptions world_of(int sinks, int motes, const motes_simulator::MoteOptions& like) {
  motes_simulator::WorldOptions options;
  options.sinks = static_cast<std::uint16_t>(sinks);
  options.wait_for_computer = true;
  auto mote = like;
  mote.board = *motes_simulator::parse_build("EM1000");
  for (int sink = 0; sink < sinks; ++sink) {
    options.add_motes(static_cast<std::uint16_t>(sink + 1), static_cast<std::uint16_t>(2 + sink * motes),
                      static_cast<std::uint16_t>(motes), mote);
  }
  return options;
}

VirtualRig::VirtualRig(int sinks, int motes, motes_simulator::MoteOptions like,
                       motes_simulator::EventLog::Callback events)
    : world(std::make_unique<motes_simulator::World>(world_of(sinks, motes, like), time,
                                                     std::vector<motes_simulator::Step>{}, std::move(events))) {
  transports.join(net);
  for (const auto port : ports_of(sinks)) {
    const auto sink = static_cast<std::uint16_t>(port - kFirstPort + 1);
    must(world->open(sink, motes_simulator::on_memory(net.tcp, {"127.0.0.1", port})));
  }
}

}  // namespace rubicon::bench::motes
