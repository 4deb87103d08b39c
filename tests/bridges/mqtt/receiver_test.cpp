#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bridges/bridge.h"
#include "bridges/mqtt/real_town.h"
#include "bridges/mqtt/receiver.h"
#include "island/virtual_island.h"
#include "support/config_text.h"
#include "support/memory/mqtt_broker.h"
#include "support/rights.h"

namespace rubicon::bridges::mqtt {
namespace {

using namespace std::chrono_literals;

constexpr const char* kRooms =
    R"({hall: {name: Hall, sensors: {temperature-1: {wave: sine, low: 19, high: 23, period: 60s}},
  actuators: {lamp-1: {value: off, delay: 200ms}, dimmer-1: {behaviour: fail}, lock-1: {value: on}}}})";
constexpr const char* kTemperature = "rubicon_6541_dummy-1_hall_sensor-temperature-1";
constexpr const char* kLamp = "rubicon_6541_dummy-1_hall_actuator-lamp-1";
constexpr const char* kLock = "rubicon_6541_dummy-1_hall_actuator-lock-1";

/// A bridge on the component beside the island.
std::unique_ptr<Bridge> bridge_of(const BridgeHost& host, const std::string& options) {
  const auto config = support::config_of(std::string_view(options));
  base::ConfigErrors errors;
  ConfigReader reader(config, "bridges.ha", errors);
  auto made = find_bridge_type("mqtt")->make(reader, "", &host);
  EXPECT_TRUE(made) << errors.text();
  return made;
}

/// Island, bridge and receiver: what a person sees there.
TEST(HomeAssistant, ShowsAnIslandAndCommandsIt) {
  island::VirtualIsland town(kRooms);
  transport::MemoryNet net(town.time);
  transport::MqttBroker broker(net, {"127.0.0.1", 1883});
  town.files.join(net);
  const BridgeHost host{"ha", town.time, *town.space, town.files, town.log, OwnerId(6541), "proxy"};
  auto bridge = bridge_of(host, R"({"broker": "localhost", "discovery": "homeassistant", "commands": "yes",
      "demand": {"active": ["**"]}})");
  bridge->start();
  Receiver receiver(town.files);
  town.time.run_for(20s);
  EXPECT_NE(receiver.state(kTemperature), "unavailable");
  EXPECT_NE(receiver.state(kTemperature), "unknown") << "it is sampled";
  EXPECT_EQ(receiver.state(kLamp), "off");
  receiver.command(kLamp, "on");
  town.time.run_for(1s);
  EXPECT_EQ(receiver.state(kLamp), "on");
  EXPECT_TRUE(receiver.has("rubicon_6541_online"));
  EXPECT_TRUE(receiver.has("rubicon_6541_dummy-1_online"));
  EXPECT_TRUE(receiver.has(kLock)) << "as what is only shown";
  bridge.reset();
  town.time.run_for(1s);
  EXPECT_EQ(receiver.state(kTemperature), "unavailable");
}

TEST_F(RealTown, ShowsTheIslandToAReceiverAlsoAfterTheBrokerWasKilled) {
  const auto audit = std::make_shared<support::CollectingAudit>();
  const auto rights =
      support::judge_of({support::rule("everybody", {support::Right::kRead, support::Right::kSet})}, audit);
  judge = rights.get();
  std::string asked;
  const auto policy = component(6541).add_policy(Pattern::parse("proxy.**").value(), [&](const tuples::RemoteSet& set) {
    asked = fmt::format("{} {} by {} within {} s", set.key, set.value, set.asker,
                        std::chrono::ceil<std::chrono::seconds>(set.time_to_live).count());
    return tuples::SetDecision::refused({ErrorCode::kRefused, "no"});
  });
  island(6541);
  bridge(70000, 6541, R"({"broker": "127.0.0.1", "discovery": "homeassistant", "commands": "yes"})");
  auto receiver = std::make_unique<Receiver>(world.local);
  const std::string lamp = "rubicon_6541_knx_1_actuator-lamp-1";
  ASSERT_TRUE(world.until([&] { return receiver->state(lamp) == "off"; })) << receiver->state(lamp);
  auto spy = std::make_unique<Spy>(world);
  std::ignore = broker->publish(
      "rubicon/6541/knx/1/actuator/lamp-1/set", "on",
      {"-V", "5", "-D", "publish", "message-expiry-interval", "60", "-D", "publish", "response-topic", "panel/answer",
       "-D", "publish", "correlation-data", "17", "-D", "publish", "user-property", "sender", "ann"});
  ASSERT_TRUE(world.until([&] { return !spy->payloads("panel/answer").empty(); }));
  EXPECT_EQ(asked, "proxy.knx.1.actuator.lamp-1.command on by bridge:ha within 60 s");
  EXPECT_THAT(spy->payloads("panel/answer").front(), ::testing::HasSubstr(R"("state":"refused")"));
  EXPECT_EQ(spy->correlation["panel/answer"], "17");
  EXPECT_THAT(audit->hosts, ::testing::ElementsAre("ann"));
  spy.reset();
  for (int i = 0; i < 20; ++i) {  // killed; what it retained is lost
    broker->kill();
    receiver.reset();
    put(6541, "proxy.knx.1.actuator.lamp-1.value", i % 2 == 0 ? "on" : "off");
    broker->start();
    ASSERT_TRUE(world.until([&] { return broker->ready(); }));
    receiver = std::make_unique<Receiver>(world.local);
    ASSERT_TRUE(world.until([&] { return receiver->state(lamp) == (i % 2 == 0 ? "on" : "off"); })) << i;
  }
}

/// What it does not take is named, and the rest is shown.
TEST_F(RealTown, ABrokerWithALimitOnPacketsGetsTheRest) {
  begin({.more = "max_packet_size 400\n"});
  island(6541);
  auto& made = bridge(70000, 6541, R"({"broker": "127.0.0.1", "discovery": "homeassistant"})");
  Spy spy(world);
  ASSERT_TRUE(world.until([&] { return spy.has("rubicon/6541/knx/1/actuator/lamp-1", "off"); }));
  EXPECT_THAT(spy.topics_with("homeassistant/device/rubicon_6541_knx_1/"), ::testing::IsEmpty());
  ASSERT_TRUE(world.until([&] { return made.status().counters.at("dropped") > 0; }));
  EXPECT_EQ(made.status().state, "up");
  EXPECT_TRUE(log.contains("packet"));
}

}  // namespace
}  // namespace rubicon::bridges::mqtt
