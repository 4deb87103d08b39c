#include "scenarios/zigbee.h"

#include <cstdio>
#include <set>

namespace rubicon::scenarios {
namespace {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

const std::string kLampPoint = std::string("00124b0010000000") + ".actuator.lamp-1";
const std::string kDimmer = std::string("00124b0010000000") + ".actuator.dimmer-1";
const std::string kTemperature = std::string("00124b0010000002") + ".sensor.temperature-1";
const std::string kBlind = std::string("00124b0010000004") + ".actuator.blindPosition-1";

TEST_F(Zigbee, PairedDevicesAreTuplesWithinSeconds) {
  begin_bridge();
  start();
  EXPECT_EQ(seen_json("00124b0010000000.description")["name"], "lamp");
  EXPECT_THAT(seen_json("00124b0010000000.description")["model"].get<std::string>(), HasSubstr("9290012573A"));
  EXPECT_EQ(seen_json(kTemperature + ".description")["unit"], "Cel");
  EXPECT_EQ(seen_json(kLampPoint + ".description")["type"], "lamp");
  world->radio().change(device("thermometer"), "temperature", 22.5);
  scheduler.run_for(1s);
  EXPECT_EQ(seen(kTemperature + ".value"), "22.5");
  EXPECT_EQ(quality(kTemperature), "good");
  EXPECT_EQ(device_status("00124b0010000002"), "reachable");
  EXPECT_EQ(seen("property.bridge.value").find("2.14.1") != std::string::npos, true);
}

/// Values that arrive without a subscriber are published: that costs nothing.
TEST_F(Zigbee, ValuesThatArriveAreTuplesWithoutASubscriber) {
  begin_bridge();
  start();
  world->radio().change(device("plug"), "power", 77);
  scheduler.run_for(1s);
  EXPECT_EQ(seen("00124b0010000001.sensor.power-1.value"), "77");
}

TEST_F(Zigbee, ACommandIsConfirmedByTheDevice) {
  begin_bridge();
  start();
  EXPECT_EQ(command(kLampPoint, "on"), tuples::Verdict::kApplied);
  scheduler.run_for(5s);
  EXPECT_EQ(command_state(kLampPoint), "confirmed");
  EXPECT_EQ(seen(kLampPoint + ".value"), "on");
  EXPECT_THAT(sets("lamp"), ElementsAre(R"({"state":"ON"})"));
}

TEST_F(Zigbee, Pitfall9_ADeviceThatIgnoresItsCommandIsNeverConfirmedByTheEcho) {
  begin_bridge();
  start();
  world->radio().set_faults(device("lamp"), {.ignores = true});
  std::set<std::string> shown;
  const auto ears = watcher().subscribe({OwnerId(1), "proxy.zigbee." + kLampPoint + ".value"}, {.passive = true},
                                        [&](const Event& event) { shown.emplace(event.tuple.value); });
  EXPECT_EQ(command(kLampPoint, "on"), tuples::Verdict::kApplied);
  scheduler.run_for(60s);
  EXPECT_THAT(command_state(kLampPoint), AnyOf("timed-out", "failed"));
  EXPECT_EQ(seen(kLampPoint + ".value"), "off");
  EXPECT_FALSE(shown.contains("on"));
}

TEST_F(Zigbee, Pitfall10_ADeviceWithoutPowerEndsTheCommandWithTheReason) {
  begin_bridge();
  start();
  world->radio().set_faults(device("lamp"), {.silent = true});
  EXPECT_EQ(command(kLampPoint, "on"), tuples::Verdict::kApplied);
  scheduler.run_for(30s);
  const auto ended = seen_json(kLampPoint + ".status")["command"];
  EXPECT_EQ(ended.value("state", ""), "failed");
  EXPECT_THAT(ended.dump(), HasSubstr("Zigbee2MQTT did not"));
}

TEST_F(Zigbee, ABlindOfOneHundredPercentIsClosed) {
  begin_bridge();
  start();
  EXPECT_EQ(command(kBlind, "100"), tuples::Verdict::kApplied);
  scheduler.run_for(5s);
  EXPECT_THAT(sets("cover"), ElementsAre(R"({"position":0})"));
  EXPECT_EQ(command_state(kBlind), "confirmed");
  EXPECT_EQ(seen(kBlind + ".value"), "100");
}

TEST_F(Zigbee, SetsOfOneTurnAreOneMessage) {
  begin_bridge();
  start();
  component(kRobot).set_remote(OwnerId(1), "proxy.zigbee." + kLampPoint + ".command", "on", {}, {});
  component(kRobot).set_remote(OwnerId(1), "proxy.zigbee." + kDimmer + ".command", "50", {}, {});
  scheduler.run_for(10s);
  ASSERT_THAT(sets("lamp"), SizeIs(1));
  EXPECT_EQ(nlohmann::json::parse(sets("lamp")[0]), nlohmann::json({{"state", "ON"}, {"brightness", 127}}));
  EXPECT_EQ(command_state(kLampPoint), "confirmed");
  EXPECT_EQ(command_state(kDimmer), "confirmed");
}

TEST_F(Zigbee, Pitfall14_AButtonIsAnEvent) {
  begin_bridge();
  start();
  std::vector<std::string> pressed;
  const auto ears = watcher().subscribe({OwnerId(1), "proxy.zigbee.00124b0010000003.sensor.action-1.value"},
                                        {.passive = true}, [&](const Event& event) {
                                          if (!event.tuple.value.empty()) pressed.emplace_back(event.tuple.value);
                                        });
  world->radio().act(device("remote"), "action", "toggle");
  scheduler.run_for(1s);
  world->radio().act(device("remote"), "action", "toggle");
  scheduler.run_for(1s);
  EXPECT_THAT(pressed, ElementsAre("toggle", "toggle"));
}

TEST_F(Zigbee, Pitfall15_OnlyDevicesWithMainsPowerAreAsked) {
  begin_bridge();
  start();
  scheduler.run_for(10s);
  const auto before = gets("plug").size();
  Flow fast;
  fast.minimum = 2s;
  auto power = want("00124b0010000001.sensor.power-1", fast);
  auto temperature = want(kTemperature, fast);
  scheduler.run_for(20s);
  EXPECT_GE(gets("plug").size(), before + 8);
  EXPECT_THAT(gets("thermometer"), IsEmpty());
  power.reset();
  scheduler.run_for(1s);
  const auto asked = gets("plug").size();
  scheduler.run_for(60s);
  EXPECT_EQ(gets("plug").size(), asked) << "nobody wants it any more";
}

TEST_F(Zigbee, Pitfall8_AfterARestartOfTheBridgeValuesAreStoredUntilTheDeviceReports) {
  begin_bridge();
  start();
  world->radio().change(device("thermometer"), "temperature", 22.5);
  scheduler.run_for(1s);
  const auto measured = watcher().get(OwnerId(1), "proxy.zigbee." + kTemperature + ".value")->user_time;
  world->restart(1min);
  scheduler.run_for(30s);
  EXPECT_EQ(quality(kTemperature), "network-down");
  scheduler.run_for(60s);
  EXPECT_EQ(seen(kTemperature + ".value"), "22.5");
  EXPECT_EQ(watcher().get(OwnerId(1), "proxy.zigbee." + kTemperature + ".value")->user_time, measured);
  world->radio().change(device("thermometer"), "humidity", 61);
  scheduler.run_for(1s);
  EXPECT_EQ(quality("00124b0010000002.sensor.humidity-1"), "good");
  EXPECT_EQ(quality(kTemperature), "stale") << "a report may be lost while the bridge did not run";
  world->radio().change(device("thermometer"), "temperature", 23);
  scheduler.run_for(1s);
  EXPECT_EQ(seen(kTemperature + ".value"), "23");
  EXPECT_EQ(quality(kTemperature), "good");
}

TEST_F(Zigbee, Pitfall4_ARenameChangesTheNameAndNoKey) {
  begin_bridge();
  start();
  ASSERT_TRUE(world->rename(device("lamp"), "hall/ceiling"));
  scheduler.run_for(1s);
  EXPECT_EQ(seen_json("00124b0010000000.description")["name"], "hall/ceiling");
  EXPECT_EQ(command(kLampPoint, "on"), tuples::Verdict::kApplied);
  scheduler.run_for(5s);
  EXPECT_EQ(command_state(kLampPoint), "confirmed");
  EXPECT_THAT(sets("hall/ceiling"), SizeIs(1));
  EXPECT_EQ(counter("renames"), 1U);
}

TEST_F(Zigbee, TheConfigurationNamesDevicesByAddressOrFriendlyName) {
  begin_bridge();
  start("devices: {lamp: {id: ceiling, name: Ceiling}, 00124b0010000001: {id: fridge}}");
  world->radio().change(device("plug"), "power", 12);
  scheduler.run_for(1s);
  EXPECT_EQ(seen("fridge.sensor.power-1.value"), "12");
  EXPECT_EQ(seen_json("ceiling.description")["name"], "Ceiling");
  ASSERT_TRUE(world->rename(device("lamp"), "sofa"));
  scheduler.run_for(1s);
  EXPECT_EQ(command("ceiling.actuator.lamp-1", "on"), tuples::Verdict::kApplied);
  scheduler.run_for(5s);
  EXPECT_EQ(command_state("ceiling.actuator.lamp-1"), "confirmed");
}

TEST_F(Zigbee, ADeviceThatIsPairedJoinsAndOneWhoseInterviewFailsWaitsInTheInbox) {
  begin_bridge();
  start();
  world->permit_join(200s);
  const auto good = world->join(zigbee_simulator::find_model("relay").value()).substr(2);
  const auto bad = world->join(zigbee_simulator::find_model("weather").value(), true).substr(2);
  scheduler.run_for(150s);
  EXPECT_EQ(seen_json(good + ".description")["name"], "0x" + good);
  EXPECT_EQ(seen(good + ".description").empty(), false);
  EXPECT_EQ(seen(bad + ".description"), "(none)");
  const auto inbox = json(watcher(), 1, "proxy.inbox.zigbee." + bad);
  EXPECT_THAT(inbox.dump(), HasSubstr("interview"));
}

TEST_F(Zigbee, WhereTheIslandAsksANewDeviceWaitsForApproval) {
  begin_bridge();
  start({}, "discovery: {new-devices: ask}\n");
  const auto waits = json(watcher(), 1, "proxy.inbox.zigbee.00124b0010000002");
  EXPECT_EQ(waits.value("name", ""), "thermometer");
  EXPECT_EQ(waits.value("why", ""), "discovery.new-devices is ask");
  EXPECT_EQ(json(watcher(), 1, "proxy.inbox").value("count", 0), 5);
  world->radio().change(device("thermometer"), "temperature", 22.5);
  scheduler.run_for(1s);
  EXPECT_EQ(seen("00124b0010000002.description"), "(none)");
  component(kRobot).set_remote(OwnerId(1), "proxy.inbox.zigbee.00124b0010000002", "approve", {}, nullptr);
  scheduler.run_for(1s);
  EXPECT_EQ(seen_json("00124b0010000002.description")["name"], "thermometer");
  world->radio().change(device("thermometer"), "temperature", 23);
  scheduler.run_for(1s);
  EXPECT_EQ(seen(kTemperature + ".value"), "23");
  EXPECT_EQ(device_status("00124b0010000002"), "reachable");
  EXPECT_EQ(json(watcher(), 1, "proxy.inbox").value("count", 0), 4);
}

TEST_F(Zigbee, WhereTheIslandIgnoresNewDevicesOnlyNamedOnesAreListed) {
  begin_bridge();
  start("devices: {lamp: {id: ceiling}}", "discovery: {new-devices: ignore}\n");
  EXPECT_EQ(seen_json("ceiling.description")["name"], "lamp");
  EXPECT_EQ(seen("00124b0010000001.description"), "(none)");
  EXPECT_EQ(json(watcher(), 1, "proxy.inbox").value("count", 9), 0);
  EXPECT_EQ(json(watcher(), 1, "proxy.inbox").value("ignored", 0), 4);
}

TEST_F(Zigbee, ADeviceThatLeavesIsGone) {
  begin_bridge();
  start();
  world->leave("0x00124b0010000001");
  scheduler.run_for(15s);
  EXPECT_EQ(seen("00124b0010000001.description"), "(none)");
  EXPECT_EQ(seen_json("00124b0010000000.description")["name"], "lamp");
}

TEST_F(Zigbee, ADeviceThatLeftWhileTheIslandDidNotRunIsGoneAfterItsStart) {
  state_file = testing::TempDir() + "zigbee-left.state";
  std::remove(state_file.c_str());
  begin_bridge();
  start();
  scheduler.run_for(1min);
  const auto asked = gets("thermometer").size();
  islands.clear();
  world->leave("0x00124b0010000001");
  scheduler.run_for(1min);
  start();
  scheduler.run_for(1min);
  EXPECT_EQ(seen_json("00124b0010000001.description")["name"], "plug") << "the broker's copy of the list may be old";
  ASSERT_TRUE(world->rename(device("cover"), "blind"));
  scheduler.run_for(12s);
  EXPECT_EQ(seen("00124b0010000001.description"), "(none)");
  EXPECT_EQ(seen_json("00124b0010000000.description")["name"], "lamp");
  EXPECT_EQ(seen_json("00124b0010000002.description")["name"], "thermometer");
  EXPECT_EQ(gets("thermometer").size(), asked) << "a device with a battery is never asked";
  std::remove(state_file.c_str());
}

TEST_F(Zigbee, AGroupActsOnItsMembersAndIsAssumed) {
  begin_bridge();
  world->registry().add_group(7, "all lamps", {"0x00124b0010000000"});
  world->restart(1s);
  scheduler.run_for(5s);
  start();
  EXPECT_EQ(seen_json("group-7.description")["name"], "all lamps");
  EXPECT_EQ(command("group-7.actuator.lamp-1", "on"), tuples::Verdict::kApplied);
  scheduler.run_for(5s);
  EXPECT_EQ(command_state("group-7.actuator.lamp-1"), "assumed");
  EXPECT_EQ(seen(kLampPoint + ".value"), "on") << "the member reports";
}

TEST_F(Zigbee, ADeviceWithoutPowerIsUnreachableWhenTheBridgeSaysSo) {
  begin_bridge();
  start();
  world->radio().set_faults(device("plug"), {.silent = true});
  scheduler.run_for(30min);
  EXPECT_EQ(device_status("00124b0010000001"), "unreachable");
  EXPECT_EQ(device_status("00124b0010000002"), "reachable");
  world->radio().set_faults(device("plug"), {});
  world->radio().change(device("plug"), "power", 5);
  scheduler.run_for(5s);
  EXPECT_EQ(device_status("00124b0010000001"), "reachable");
}

}  // namespace
}  // namespace rubicon::scenarios
