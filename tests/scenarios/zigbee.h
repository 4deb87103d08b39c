#pragma once

#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <vector>

#include "apps/simulators/zigbee/simulator.h"
#include "apps/simulators/zigbee/world.h"
#include "island/network_types.h"
#include "scenarios/ecology.h"
#include "state/state_store.h"
#include "support/memory/mqtt_broker.h"

namespace rubicon::scenarios {

/// An island with a ZigBee network, the broker, and a bridge with simulated devices on the other side of it.
class Zigbee : public Ecology {
 protected:
  static constexpr std::uint32_t kWatcher = 70000, kRobot = 70001;
  static constexpr const char* kBrokerHost = "10.0.0.9";
  // Devices in the order in which SetUp() adds them.
  static constexpr const char *kLamp = "00124b0010000000", *kPlug = "00124b0010000001", *kAir = "00124b0010000002",
                              *kRemote = "00124b0010000003", *kCover = "00124b0010000004";

  Zigbee() {
    transports.join(net, "10.0.0.1");
    bridge_transports.join(net, "10.0.0.2");
    sees_ = watcher().subscribe({std::nullopt, "**"}, {.passive = true}, [](const Event&) {});
  }
  ~Zigbee() override {
    islands.clear();
    components.clear();
  }

  /// The bridge with a lamp, a plug, a thermometer, a remote control and a cover. Names are those of the models.
  void begin_bridge(zigbee_simulator::WorldOptions options = {}) {
    world = std::make_unique<zigbee_simulator::World>(options, scheduler, Log(log, "bridge"));
    transport::MqttOptions where;
    where.host = kBrokerHost;
    bridge =
        std::make_unique<zigbee_simulator::BrokerLine>(*world, where, scheduler, bridge_transports, Log(log, "bridge"));
    for (const auto* model : {"lamp", "plug", "thermometer", "remote", "cover"})
      ASSERT_TRUE(world->add(zigbee_simulator::find_model(model).value(), model));
    ASSERT_TRUE(bridge->open());
    scheduler.run_for(2s);
  }
  island::Island& start(const std::string& more = {}, const std::string& discovery = {}) {
    const auto text = std::string("island: {id: 1, name: test}\nnetworks:\n  zigbee: {type: zigbee, broker: ") +
                      kBrokerHost + (more.empty() ? "" : ", " + more) + "}\n" + discovery;
    base::ConfigErrors errors;
    const auto tree = config::parse_yaml(text, "island.yaml");
    EXPECT_TRUE(tree) << text;
    auto config = island::read_island_config(tree.value(), island::network_types(), errors);
    std::unique_ptr<state::StateStore> store;
    if (!state_file.empty()) store = std::move(*state::StateStore::open(state_file, OwnerId(1), {}));
    auto made = island::Island::make(std::move(config), scheduler, transports, log, ecology, errors, std::move(store));
    EXPECT_TRUE(made.has_value()) << errors.text();
    auto& island = *(islands[1] = std::move(*made));
    island.start();
    scheduler.run_for(1s);
    return island;
  }

  TupleSpace& watcher() { return component(kWatcher); }
  /// `seen("00124b0010000000.actuator.lamp-1.value")`
  std::string seen(const std::string& key) { return value(watcher(), 1, "proxy.zigbee." + key); }
  nlohmann::json seen_json(const std::string& key) { return json(watcher(), 1, "proxy.zigbee." + key); }
  std::string quality(const std::string& point) { return seen_json(point + ".status").value("quality", "(none)"); }
  std::string device_status(const std::string& device) {
    return seen_json(device + ".status").value("status", "(none)");
  }
  std::string line() { return seen_json("status").value("line", seen_json("status").dump()); }
  std::uint64_t counter(const std::string& name) {
    scheduler.run_for(1s);
    const auto text = seen("property." + name + ".value");
    return text.empty() || text.front() == '(' ? ~std::uint64_t{0} : std::stoull(text);
  }
  /// Sets the command; `applied` if the island accepted it.
  tuples::Verdict command(const std::string& point, const std::string& text) {
    auto verdict = tuples::Verdict::kExpired;
    component(kRobot).set_remote(OwnerId(1), "proxy.zigbee." + point + ".command", text, {},
                                 [&](const tuples::Reply& reply) { verdict = reply.verdict; });
    scheduler.run_for(10ms);
    return verdict;
  }
  std::string command_state(const std::string& point) {
    const auto status = seen_json(point + ".status");
    return status.contains("command") ? status["command"].value("state", status["command"].dump()) : status.dump();
  }
  [[nodiscard]] Handle want(const std::string& point, Flow flow = {}) {
    auto subscription =
        component(kRobot).subscribe({OwnerId(1), "proxy.zigbee." + point + ".value"}, flow, [](const Event&) {});
    scheduler.run_ready();
    return subscription;
  }
  std::vector<std::string> sets(const std::string& name) { return broker.published("zigbee2mqtt/" + name + "/set"); }
  std::vector<std::string> gets(const std::string& name) { return broker.published("zigbee2mqtt/" + name + "/get"); }
  zigbee_simulator::RadioDevice& device(const std::string& name) { return *world->registry().find(name); }

  std::string state_file;  ///< empty: the island remembers nothing
  transport::MemoryNet net{scheduler};
  transport::MemoryTransports bridge_transports;
  transport::MqttBroker broker{net, {kBrokerHost, 1883}};
  std::unique_ptr<zigbee_simulator::World> world;
  std::unique_ptr<zigbee_simulator::BrokerLine> bridge;

 private:
  Handle sees_;
};

}  // namespace rubicon::scenarios
