#include "zigbee/rig.h"

#include <fmt/format.h>

namespace rubicon::bench::zigbee {

using namespace std::chrono_literals;

std::string island_yaml() {
  return fmt::format(
      "island: {{id: {}, name: bench}}\nnetworks:\n  zigbee: {{type: zigbee, broker: \"127.0.0.1:{}\"}}\n",
      number(kIsland), kPort);
}

std::unique_ptr<island::Island> start_island(Scheduler& scheduler, transport::Transports& transports,
                                             tuples::Ecology& ecology) {
  return bench::start_island(island_yaml(), scheduler, transports, ecology);
}

std::set<std::string> listed_devices(island::Island& island) {
  std::set<std::string> keys;
  island.space().list({kIsland, "proxy.zigbee.*.status"},
                      [&keys](const tuples::TupleView& tuple) { keys.emplace(tuple.key); });
  return keys;
}

std::string line_of(island::Island& island) {
  const auto status = island.space().get(kIsland, "proxy.zigbee.status");
  return status ? Json::parse(status->value).value("line", "") : std::string();
}

VirtualRig::VirtualRig() {
  island = start_island(time, transports, ecology);
  virtual_time.run_for(1s);
}

void VirtualRig::say(std::string_view topic, std::string_view payload) {
  time.run([&] { transports.deliver(topic, payload); });
  virtual_time.run_for(1ms);
}

void VirtualRig::begin(const std::string& list) {
  say("zigbee2mqtt/bridge/info", kBridgeInfo);
  say("zigbee2mqtt/bridge/state", R"({"state":"online"})");
  say("zigbee2mqtt/bridge/devices", list);
  virtual_time.run_for(5s);
}

}  // namespace rubicon::bench::zigbee
