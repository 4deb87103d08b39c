#include "apps/simulators/zigbee/simulator.h"
#include "apps/simulators/zigbee/world.h"
#include "bridges/mqtt/real_town.h"
#include "config/yaml.h"
#include "island/island.h"
#include "island/network_types.h"

namespace rubicon::bridges::mqtt {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class LoopsAtOneBroker : public RealTown {
 protected:
  static constexpr const char* kLamp = "rubicon/1/knx/1/actuator/lamp-1";
  std::string value(std::uint32_t owner, const std::string& key) {
    const auto tuple = component(70000).get(OwnerId(owner), key);
    return tuple ? std::string(tuple->value) : "(none)";
  }
};

TEST_F(LoopsAtOneBroker, IslandsThatMirrorOneAnotherDoNotEcho) {
  island(1);
  island(2);
  constexpr const char* kBoth = R"({"broker": "127.0.0.1", "patterns": ["proxy.**"], "commands": "yes",
      "discovery": "homeassistant"})";
  bridge(70001, 1, kBoth);
  bridge(70002, 2, kBoth);
  Spy spy(world);
  const auto shown = [&](const std::string& value, std::size_t times) {
    const auto all = spy.payloads(kLamp);
    return std::count(all.begin(), all.end(), value) >= static_cast<std::ptrdiff_t>(times);
  };
  ASSERT_TRUE(world.until([&] { return shown("off", 1) && !spy.payloads("rubicon/2/knx/1/actuator/lamp-1").empty(); }));
  spy.rounds();
  spy.seen.clear();
  put(1, "proxy.knx.1.actuator.lamp-1.value", "on");
  ASSERT_TRUE(world.until([&] { return shown("on", 2); }));
  spy.rounds();
  EXPECT_THAT(spy.payloads(kLamp), ElementsAre("on", "on")) << "once by each bridge";
  EXPECT_THAT(spy.topics_with("/set"), IsEmpty());
}

/// A real ZigBee network at the broker of the bridge, in both directions.
TEST_F(LoopsAtOneBroker, AZigbeeNetworkIsNotShownAtItsOwnBroker) {
  auto& scheduler = world.loop.scheduler();
  zigbee_simulator::World zigbee({}, scheduler, Log(log, "zigbee"));
  transport::MqttOptions where;
  where.host = "127.0.0.1";
  zigbee_simulator::BrokerLine line(zigbee, where, scheduler, world.local, Log(log, "zigbee"));
  ASSERT_TRUE(zigbee.add(zigbee_simulator::find_model("plug").value(), "plug"));
  ASSERT_TRUE(line.open());
  const auto tree = config::parse_yaml(
      "island: {id: 1, name: test}\nnetworks:\n  zigbee: {type: zigbee, broker: 127.0.0.1}\n"
      "  dummy: {type: dummy, simulate: {1: {name: Hall, actuators: {lamp-1: {value: off}}}}}\n",
      "island.yaml");
  base::ConfigErrors errors;
  auto config = island::read_island_config(tree.value(), island::network_types(), errors);
  auto made = island::Island::make(std::move(config), scheduler, world.local, log, ecology, errors);
  ASSERT_TRUE(made.has_value()) << errors.text();
  (*made)->start();
  const auto sees = component(70000).subscribe({OwnerId(1), "**"}, {.passive = true}, [](const Event&) {});
  const std::string plug = "proxy.zigbee.00124b0010000000.actuator.switch-1.value";
  ASSERT_TRUE(world.until([&] { return value(1, plug) != "(none)"; }));
  bridge(70001, 1, R"({"broker": "127.0.0.1", "discovery": "homeassistant", "commands": "yes"})");
  Spy spy(world);
  const std::string lamp = "rubicon/1/dummy/1/actuator/lamp-1";
  ASSERT_TRUE(world.until([&] { return spy.has(lamp, "off"); }));
  spy.publish("zigbee2mqtt/plug/set", R"({"state":"OFF"})");
  ASSERT_TRUE(world.until([&] { return value(1, plug) == "off"; })) << "the island sees it";
  spy.publish(lamp + "/set", "on");
  ASSERT_TRUE(world.until([&] { return spy.has(lamp, "on"); }));
  spy.rounds();
  EXPECT_THAT(spy.topics_with("rubicon/1/zigbee"), IsEmpty());
  EXPECT_THAT(spy.topics_with("rubicon_1_zigbee"), IsEmpty());
  EXPECT_THAT(spy.payloads("zigbee2mqtt/plug/set"), SizeIs(1)) << "ours";
  EXPECT_THAT(spy.payloads(lamp + "/set"), SizeIs(1));
}

}  // namespace
}  // namespace rubicon::bridges::mqtt
