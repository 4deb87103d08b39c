#include "motes/rig.h"

#include <fmt/format.h>

#include <stdexcept>

#include "config/yaml.h"
#include "island/network_types.h"

namespace rubicon::bench::motes {

namespace {

base::NullLogSink& nowhere() {
  static base::NullLogSink log;
  return log;
}

}  // namespace

void must(const Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().text);
}

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

std::unique_ptr<island::Island> start_island(const std::string& yaml, Scheduler& scheduler,
                                             transport::Transports& transports, tuples::Ecology& ecology,
                                             std::unique_ptr<state::StateStore> state) {
  base::ConfigErrors errors;
  auto config =
      island::read_island_config(must(config::parse_yaml(yaml, "bench.yaml")), island::network_types(), errors);
  if (!errors.empty()) throw std::runtime_error(errors.text());
  auto made =
      island::Island::make(std::move(config), scheduler, transports, nowhere(), ecology, errors, std::move(state));
  if (!errors.empty()) throw std::runtime_error(errors.text());
  auto island = must(std::move(made));
  island->start();
  return island;
}

bool reachable(island::Island& island, std::uint16_t sink, std::uint16_t mote) {
  const auto status = island.space().get(kIslandOwner, fmt::format("proxy.wsn-{}.{}.status", sink, mote));
  return status && status->value.find("\"reachable\"") != std::string_view::npos;
}

Component::Component(tuples::Ecology& ecology, Scheduler& scheduler, std::uint32_t id)
    : link_(must(ecology.join(OwnerId(id)))), space_(std::make_unique<TupleSpace>(OwnerId(id), scheduler, *link_)) {}

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
