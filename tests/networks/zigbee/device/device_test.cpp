#include "networks/zigbee/device.h"

#include "device_support.h"
#include "networks/zigbee/device/state_message.h"

namespace rubicon::networks::zigbee {
namespace {

using Texts = std::vector<std::string>;
using ZigbeeDeviceTest = DeviceTest;

TEST_F(ZigbeeDeviceTest, ItJoinsWithItsPointsAndNothingGoesStale) {
  start(record_of(definitions::kLamp), false);
  const auto joins = host.all<model::Join>();
  ASSERT_EQ(joins.size(), 1U);
  EXPECT_EQ(joins[0].name, "kitchen/one");
  EXPECT_EQ(joins[0].model, "Maker M1");
  EXPECT_EQ(joins[0].capabilities.size(), device->points().size() + 1);  // and the rate
  EXPECT_EQ(joins[0].capabilities.back().type_name, "rate");
  for (std::size_t i = 0; i < device->points().size(); ++i) EXPECT_EQ(joins[0].capabilities[i].deadline, Duration(0));
  run(hours(10));
  EXPECT_TRUE(host.published.empty());
}

TEST_F(ZigbeeDeviceTest, OnlyADeviceThatCanBePolledHasARate) {
  for (const bool battery : {false, true}) {
    for (const auto definition : {definitions::kPlug, definitions::kFan}) {
      forget();
      start(record_of(definition, battery), false);
      const auto join = host.all<model::Join>().at(0);
      const bool rate = join.capabilities.back().type_name == "rate";
      EXPECT_EQ(rate, !battery && definition == definitions::kPlug);
    }
  }
}

TEST_F(ZigbeeDeviceTest, ARenameJoinsAgainAndSetsGoToTheNewName) {
  start(record_of(definitions::kPlug));
  auto record = device->record();
  device->update(record);
  EXPECT_TRUE(host.delivered.empty());
  record.name = "hall";
  device->update(record);
  ASSERT_EQ(host.all<model::Join>().size(), 1U);
  EXPECT_EQ(host.all<model::Join>()[0].name, "hall");
  commanded("state", true);
  EXPECT_EQ(host.published.back().name, "hall");
}

TEST_F(ZigbeeDeviceTest, AfterANewDefinitionPointsThatChangedAreDeliveredAgain) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":20,"humidity":40)");
  const auto before = point("temperature");
  forget();
  auto record = record_of(definitions::kWeather, true);
  auto leaves = record.leaves.items();
  auto second = leaves[0];
  second.property = "temperature_probe";
  second.endpoint = "probe";
  leaves[0].endpoint = "room";
  leaves.push_back(second);
  record.leaves = std::move(leaves);
  device->update(std::move(record));
  ASSERT_NE(point("temperature"), before);
  report(R"("temperature":20,"humidity":40)");
  EXPECT_EQ(readings(), (Values{{"temperature", "20"}}));
}

TEST_F(ZigbeeDeviceTest, ANewDefinitionDoesNotProveAnEcho) {
  start(record_of(definitions::kLamp));
  report(R"("state":"OFF","brightness":10)");
  commanded("brightness", 50.0);
  report(R"("state":"OFF","brightness":10)");
  echo(R"("state":"OFF","brightness":127)");
  forget();
  auto record = record_of(definitions::kLamp);
  auto leaves = record.leaves.items();
  for (auto& leaf : leaves) {
    if (leaf.property == "brightness") leaf.endpoint = "left";
  }
  record.leaves = std::move(leaves);
  device->update(std::move(record));
  report(R"("state":"OFF","brightness":127)");
  run(milliseconds(110));
  EXPECT_EQ(readings(), (Values{{"state", "off"}}));
  run(milliseconds(300));
  report(R"("state":"OFF","brightness":127)");
  run(milliseconds(110));
  EXPECT_EQ(readings(), (Values{{"state", "off"}, {"brightness", "50"}}));
}

TEST_F(ZigbeeDeviceTest, WhenTheLineComesADeviceWithMainsPowerIsAskedForItsState) {
  start(record_of(definitions::kLamp), false);
  device->line_up();
  run(seconds(2));
  EXPECT_EQ(gets(), Texts{R"({"state":"","brightness":"","color":""})"});
  forget();
  start(record_of(definitions::kValve, true), false);
  device->line_up();
  run(hours(1));
  EXPECT_TRUE(host.published.empty());
}

TEST_F(ZigbeeDeviceTest, AvailabilityIsPassedOn) {
  start(record_of(definitions::kPlug));
  device->availability(false);
  ASSERT_EQ(host.all<model::Unreachable>().size(), 1U);
  EXPECT_EQ(host.all<model::Unreachable>()[0].reason, "Zigbee2MQTT: not available");
  device->availability(true);
  EXPECT_EQ(host.all<model::KeepAlive>().size(), 1U);
  run(seconds(3));
  EXPECT_EQ(gets().size(), 1U);
}

TEST_F(ZigbeeDeviceTest, WhereTheBridgePublishesAvailabilityNoOtherLimitApplies) {
  start(record_of(definitions::kWeather, true));
  device->bridge_decides(true);
  report(R"("temperature":20)");
  forget();
  run(hours(100));
  EXPECT_TRUE(host.all<model::Unreachable>().empty());
  device->bridge_decides(false);
  run(hours(26));
  EXPECT_EQ(host.all<model::Unreachable>().size(), 1U);
}

// zigbee.md, section 12, pitfall 17
TEST_F(ZigbeeDeviceTest, Pitfall17_WithoutAvailabilityADeviceThatIsSilentTooLongIsUnreachable) {
  auto record = record_of(definitions::kWeather, true);
  start(std::move(record));
  report(R"("temperature":20)");
  forget();
  run(hours(24));
  EXPECT_TRUE(host.all<model::Unreachable>().empty());
  run(hours(2));
  ASSERT_EQ(host.all<model::Unreachable>().size(), 1U);
  EXPECT_EQ(host.all<model::Unreachable>()[0].reason, "not heard for 25 h");
  run(hours(100));
  EXPECT_EQ(host.all<model::Unreachable>().size(), 1U);
  report(R"("temperature":21)");
  EXPECT_EQ(readings(), (Values{{"temperature", "21"}}));
  EXPECT_TRUE(host.published.empty());
}

TEST_F(ZigbeeDeviceTest, ADeviceThatReportsOnlyChangesIsAskedBeforeItIsCalledUnreachable) {
  start(record_of(definitions::kPlug));
  report(R"("state":"ON")");
  forget();
  run(minutes(61));
  EXPECT_EQ(gets(), Texts{R"({"state":""})"});
  EXPECT_EQ(host.all<model::Unreachable>().size(), 1U);  // no answer within 15 s
  report(R"("state":"ON")");
  forget();
  run(minutes(60));
  report(R"("state":"ON")");
  run(minutes(5));
  EXPECT_EQ(gets().size(), 1U);
  EXPECT_TRUE(host.all<model::Unreachable>().empty());
}

TEST_F(ZigbeeDeviceTest, AMainsDeviceThatCanNeitherReportNorAnswerMayBeQuietForEver) {
  start(record_of(definitions::kFan));
  report(R"("state":"ON")");
  forget();
  run(hours(1000));
  EXPECT_TRUE(host.delivered.empty());
  EXPECT_TRUE(host.published.empty());
}

TEST_F(ZigbeeDeviceTest, AProbeAsksADeviceThatCanBeAsked) {
  Message probe;
  probe.body = model::Probe{};
  start(record_of(definitions::kPlug));
  ASSERT_TRUE(device->send(probe));
  run(seconds(1));
  EXPECT_EQ(gets(), Texts{R"({"state":""})"});
  forget();
  start(record_of(definitions::kValve, true));
  const auto refused = device->send(probe);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  run(seconds(1));
  EXPECT_TRUE(host.published.empty());
}

TEST_F(ZigbeeDeviceTest, WhatIsNoRequestForADeviceIsUnsupported) {
  start(record_of(definitions::kPlug));
  Message message;
  message.body = model::Opaque{"x", {}};
  const auto done = device->send(message);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::kUnsupported);
}

TEST_F(ZigbeeDeviceTest, AGroupIsAssumedAndItsStateIsShownAsStored) {
  auto record = record_of(definitions::kPlug);
  record.address = "group-7";
  record.name = "lamps";
  record.power_source.clear();
  device = std::make_unique<Device>(host, models, std::move(record));
  const auto joins = host.all<model::Join>();
  for (const auto& one : joins.at(0).capabilities) {
    EXPECT_FALSE(one.reports);
    EXPECT_FALSE(one.sampled);
  }
  device->line_up();
  run(seconds(20));
  forget();
  commanded("state", true);
  EXPECT_EQ(sets(), Texts{R"({"state":"ON"})"});
  EXPECT_EQ(answers(), Texts{});
  say_plain(R"("state":"ON")");
  EXPECT_EQ(answers(), Texts{"1 sent"}) << "the echo of the group";
  EXPECT_TRUE(raw_readings().empty());
  say_plain(R"("state":"OFF")");
  EXPECT_EQ(readings(false), (Values{{"state", "off"}}));
  EXPECT_TRUE(readings().empty());
  run(hours(48));
  EXPECT_TRUE(gets().empty());
  EXPECT_TRUE(host.all<model::Unreachable>().empty());
}

TEST_F(ZigbeeDeviceTest, TheStateOfAGroupThatRepeatsItselfProvesNothing) {
  auto record = record_of(definitions::kPlug);
  record.address = "group-7";
  record.power_source.clear();
  start(std::move(record));
  report(R"("state":"ON")");
  forget();
  commanded("state", true);
  report(R"("state":"ON")");
  EXPECT_EQ(answers(), Texts{"1 sent"});
  report(R"("state":"ON")");
  run(seconds(10));
  EXPECT_TRUE(readings().empty());
}

TEST(LastSeen, EachFormOfZigbee2MqttIsRead) {
  const WallTime expected{std::chrono::milliseconds(1'763'684'209'837)};
  EXPECT_EQ(device::read_last_seen(R"("2025-11-21T00:16:49.837Z")"), expected);
  EXPECT_EQ(device::read_last_seen(R"("2025-11-21T01:16:49.837+01:00")"), expected);
  EXPECT_EQ(device::read_last_seen(R"("2025-11-20T20:46:49.837-0330")"), expected);
  EXPECT_EQ(device::read_last_seen("1763684209837"), expected);
  EXPECT_EQ(device::read_last_seen(R"("2025-11-21T00:16:49Z")"), expected - std::chrono::milliseconds(837));
  for (const std::string wrong :
       {"", "\"", "\"\"", "null", "0", "-5", "9999999999999999", R"("2025-11-21")", R"("2025-13-21T00:16:49Z")",
        R"("2025-11-21T24:16:49Z")", R"("2025-11-21T00:16:49")", R"("2025-11-21T00:16:49Zx")",
        R"("1969-11-21T00:16:49Z")", R"("2200-01-01T00:00:00Z")", "7258118400000", R"("2025-11-21T00:16:4")"})
    EXPECT_FALSE(device::read_last_seen(wrong)) << wrong;
}

}  // namespace
}  // namespace rubicon::networks::zigbee
