#include <map>
#include <random>

#include "island.h"

namespace rubicon::proxy {
namespace {

using Directory = Island;

TEST_F(Directory, AJoinMakesAllTuplesEmptyAndUnknown) {
  start();
  join("1.4.6", lamp());
  const std::string device = "proxy.hall.1_4_6";
  for (const auto* point : {".sensor.glow-1", ".sensor.glow-2", ".actuator.flap-1"}) {
    EXPECT_EQ(text(device + point + ".value"), "");
    EXPECT_EQ(quality(device + point), "unknown");
    EXPECT_TRUE(exists(device + point + ".description"));
  }
  EXPECT_EQ(text(device + ".actuator.flap-1.command"), "");
  EXPECT_FALSE(exists(device + ".sensor.glow-1.command"));
  EXPECT_EQ(json(device + ".status")["status"], "reachable");
}

TEST_F(Directory, FindsEachDeviceByItsAddressWhoeverCameOrLeftMeanwhile) {
  start();
  std::map<std::string, double> present;
  std::mt19937 dice(3);
  for (int i = 0; i < 3000; ++i) {
    const auto address = std::to_string(dice() % 60);
    if (dice() % 3 == 0) {
      say(address, model::Leave{"test"});
      present.erase(address);
      continue;
    }
    if (!present.contains(address)) join(address, lamp());
    report(address, sensor(kGlow), present[address] = static_cast<double>(i) / 4);
  }
  for (int device = 0; device < 60; ++device) {
    const auto address = std::to_string(device);
    const auto known = present.find(address);
    EXPECT_EQ(exists("proxy.hall." + address + ".status"), known != present.end()) << address;
    if (known == present.end()) continue;
    EXPECT_EQ(text("proxy.hall." + address + ".sensor.glow-1.value"), model::to_text(known->second)) << address;
  }
}

/// Some messages are looked at before they are routed: what those before them do to their devices must not matter.
TEST_F(Directory, ReadingsThatWaitTogetherFollowTheJoinsAndLeavesBetweenThem) {
  start();
  std::vector<std::pair<std::string, model::Body>> waiting;
  for (int i = 0; i < 50; ++i) {
    const auto address = std::to_string(i % 5);
    waiting.emplace_back(address, lamp());
    waiting.emplace_back(address, updates(sensor(kGlow), static_cast<double>(i)));
    if (i < 45) waiting.emplace_back(address, model::Leave{"test"});
  }
  for (auto& [address, body] : waiting) hall().say(address, std::move(body));
  time.run_ready();
  for (int i = 45; i < 50; ++i) {
    EXPECT_EQ(text("proxy.hall." + std::to_string(i % 5) + ".sensor.glow-1.value"), std::to_string(i));
  }
}

TEST_F(Directory, DescribesDeviceAndPoints) {
  start();
  auto message = lamp();
  message.capabilities[0].maximum = 500;
  message.capabilities[1].unit = "klx";
  join("7", message);
  const auto device = json("proxy.hall.7.description");
  EXPECT_EQ(device["name"], "Lamp");
  EXPECT_EQ(device["model"], "ACME L1");
  EXPECT_EQ(device["address"], "7");
  EXPECT_EQ(device["network"], "hall");
  EXPECT_EQ(device["sensors"], (std::vector<std::string>{"glow-1", "glow-2"}));
  EXPECT_EQ(device["actuators"], (std::vector<std::string>{"flap-1"}));
  const auto glow = json("proxy.hall.7.sensor.glow-1.description");
  EXPECT_EQ(glow["type"], "glow");
  EXPECT_EQ(glow["type_id"], 0x8001);
  EXPECT_EQ(glow["unit"], "lx");
  EXPECT_EQ(json("proxy.hall.7.sensor.glow-2.description")["unit"], "klx") << "its own goes before that of the type";
  EXPECT_EQ(glow["minimum"], 0);
  EXPECT_EQ(glow["maximum"], 500);
  EXPECT_EQ(glow["report"], "state");
  EXPECT_EQ(glow["instance"], "1");
  EXPECT_EQ(json("proxy.hall.7.actuator.flap-1.description")["words"], (std::vector<std::string>{"shut", "open"}));
}

TEST_F(Directory, UsesTheNamesGivenAtInstallation) {
  auto& names = rules().devices["7"];
  names.id = "kitchen";
  names.name = "Kitchen lamp";
  names.sensors["glow-1"] = "window";
  start();
  join("7", lamp());
  EXPECT_TRUE(exists("proxy.hall.kitchen.sensor.glow-window.value"));
  EXPECT_FALSE(exists("proxy.hall.kitchen.sensor.glow-1.value"));
  EXPECT_EQ(json("proxy.hall.kitchen.description")["name"], "Kitchen lamp");
  report("7", sensor(kGlow), 12.5);
  EXPECT_EQ(text("proxy.hall.kitchen.sensor.glow-window.value"), "12.5");
}

TEST_F(Directory, WarnsOfNamesThatNoPointOfTheDeviceBears) {
  auto& names = rules().devices["7"];
  names.sensors["golw-1"] = "window";
  names.actuators["flap-1"] = "top";
  start();
  join("7", lamp());
  std::size_t warnings = 0;
  for (const auto& line : log.lines) {
    if (line.find("the device has no such") == line.npos) continue;
    ++warnings;
    EXPECT_THAT(line, testing::HasSubstr(".devices.7.sensors.golw-1: the device has no such sensor; did you mean "
                                         "'glow-1' or 'glow-2'? There are: glow-1, glow-2"));
  }
  EXPECT_EQ(warnings, 1u);
  join("7", lamp());
  EXPECT_EQ(static_cast<std::size_t>(
                std::count_if(log.lines.begin(), log.lines.end(),
                              [](const auto& line) { return line.find("the device has no such") != line.npos; })),
            warnings)
      << "it says the same again";
}

TEST_F(Directory, HonoursAnotherPrefix) {
  config.prefix = "house";
  start();
  join("7", lamp());
  EXPECT_TRUE(exists("house.hall.7.sensor.glow-1.value"));
  EXPECT_EQ(json("house.networks"), (std::vector<std::string>{"hall"}));
}

TEST_F(Directory, RefusesASecondAddressForOneKey) {
  start();
  join("1.4.6", lamp());
  report("1.4.6", sensor(kGlow), 1.5);
  join("1_4_6", lamp());
  report("1_4_6", sensor(kGlow), 9.5);
  EXPECT_EQ(text("proxy.hall.1_4_6.sensor.glow-1.value"), "1.5");
  EXPECT_TRUE(log.contain("belongs to '1.4.6'"));
  time.run_for(1s);
  EXPECT_EQ(text("proxy.hall.property.refused-joins.value"), "1");
}

TEST_F(Directory, KeepsAConfiguredIdForItsAddress) {
  rules().devices["7"].id = "8";
  start();
  join("8", lamp());
  EXPECT_FALSE(exists("proxy.hall.8.status"));
  join("7", lamp());
  EXPECT_EQ(json("proxy.hall.8.description")["address"], "7");
}

TEST_F(Directory, LogsIdsThatCollideAtLoad) {
  rules().devices["7"].id = "x";
  rules().devices["8"].id = "x";
  start();
  EXPECT_TRUE(log.contain("both become x"));
}

TEST_F(Directory, RefusesAndCountsJoinsBeyondTheCap) {
  config.max_devices = 2;
  start();
  for (const auto* device : {"1", "2", "3", "4"}) join(device, lamp());
  EXPECT_TRUE(exists("proxy.hall.2.status"));
  EXPECT_FALSE(exists("proxy.hall.3.status"));
  time.run_for(1s);
  EXPECT_EQ(text("proxy.hall.property.refused-joins.value"), "2");
  say("1", model::Leave{"switched off"});
  join("4", lamp());
  EXPECT_TRUE(exists("proxy.hall.4.status"));
}

TEST_F(Directory, ARejoinKeepsValuesAndDropsWhatVanished) {
  start();
  join("7", lamp());
  report("7", sensor(kGlow, "1"), 1.5);
  report("7", sensor(kGlow, "2"), 2.5);
  auto changed = lamp();
  changed.capabilities = {capability(Kind::kSensor, kMood, "1"), capability(Kind::kSensor, kGlow, "2")};
  join("7", changed);
  EXPECT_FALSE(exists("proxy.hall.7.sensor.glow-1.value"));
  EXPECT_FALSE(exists("proxy.hall.7.actuator.flap-1.command"));
  EXPECT_EQ(text("proxy.hall.7.sensor.glow-2.value"), "2.5");
  EXPECT_EQ(quality("proxy.hall.7.sensor.glow-2"), "good");
  EXPECT_EQ(quality("proxy.hall.7.sensor.mood-1"), "unknown");
  EXPECT_EQ(json("proxy.hall.7.description")["sensors"], (std::vector<std::string>{"mood-1", "glow-2"}));
}

/// A type that only the device knows is called in the keys what its first join calls it.
TEST_F(Directory, ARejoinThatNamesATypeKeepsTheKeys) {
  start();
  constexpr TypeId kOwn{40'017};
  auto plain = lamp();
  plain.capabilities = {capability(Kind::kSensor, kOwn, "1")};
  join("7", plain);
  report("7", sensor(kOwn, "1"), 1.5);
  ASSERT_EQ(text("proxy.hall.7.sensor.type40017-1.value"), "1.5");
  auto named = plain;
  named.capabilities[0].type_name = "sap-flow";
  join("7", named);
  EXPECT_EQ(text("proxy.hall.7.sensor.type40017-1.value"), "1.5");
  EXPECT_FALSE(exists("proxy.hall.7.sensor.sap_flow-1.value"));
  EXPECT_EQ(json("proxy.hall.7.description")["sensors"], (std::vector<std::string>{"type40017-1"}));
  join("8", named);
  EXPECT_TRUE(exists("proxy.hall.8.sensor.sap_flow-1.value"));
}

TEST_F(Directory, ARepeatedJoinPublishesNothingNew) {
  start();
  join("7", lamp());
  int sets = 0;
  const auto ears = space->subscribe({kIsland, "proxy.hall.7.**"}, {.passive = true}, [&](const Event&) { ++sets; });
  time.run_for(2s);
  sets = 0;
  join("7", lamp());
  time.run_for(2s);
  EXPECT_EQ(sets, 0);
}

TEST_F(Directory, ALeaveDeletesAllTuplesOfTheDevice) {
  start();
  join("7", lamp());
  join("8", lamp());
  say("7", model::Leave{"removed"});
  time.run_for(1s);
  int left = 0;
  space->list({kIsland, "proxy.hall.7.**"}, [&](const tuples::TupleView&) { ++left; });
  EXPECT_EQ(left, 0);
  EXPECT_TRUE(exists("proxy.hall.8.status"));
  EXPECT_EQ(json("proxy.hall.devices"), (std::vector<std::string>{"8"}));
}

TEST_F(Directory, ADeviceThatJoinsAfterItLeftIsANewDevice) {
  start();
  join("7", lamp());
  report("7", sensor(kGlow), 1.5);
  say("7", model::Leave{""});
  join("7", lamp());
  EXPECT_EQ(text("proxy.hall.7.sensor.glow-1.value"), "");
  report("7", sensor(kGlow), 2.5);
  EXPECT_EQ(text("proxy.hall.7.sensor.glow-1.value"), "2.5");
}

TEST_F(Directory, AValueOfAnUndeclaredSensorMakesThatSensor) {
  start();
  join("7", lamp());
  report("7", sensor(kMood, "9"), std::string("night"));
  EXPECT_EQ(text("proxy.hall.7.sensor.mood-9.value"), "night");
  EXPECT_EQ(quality("proxy.hall.7.sensor.mood-9"), "good");
  EXPECT_EQ(json("proxy.hall.7.description")["sensors"], (std::vector<std::string>{"glow-1", "glow-2", "mood-9"}));
  join("7", lamp());
  EXPECT_EQ(text("proxy.hall.7.sensor.mood-9.value"), "night");
}

TEST_F(Directory, CountsValuesOfUndeclaredPointsOfUnknownType) {
  start();
  join("7", lamp());
  report("7", sensor(TypeId{0x9999}), 1.5);
  report("7", actuator(kKnob, "3"), std::int64_t{3});
  time.run_for(1s);
  EXPECT_EQ(text("proxy.hall.property.undeclared-points.value"), "2");
}

TEST_F(Directory, CountsMessagesOfDevicesThatNeverJoined) {
  start();
  report("99", sensor(kGlow), 1.5);
  say("99", model::KeepAlive{});
  time.run_for(1s);
  EXPECT_FALSE(exists("proxy.hall.99.status"));
  EXPECT_EQ(text("proxy.hall.property.unknown-devices.value"), "2");
}

TEST_F(Directory, RefusesTwoPointsOfOneName) {
  rules().devices["7"].sensors = {{"glow-1", "x"}, {"glow-2", "x"}};
  start();
  join("7", lamp());
  report("7", sensor(kGlow, "1"), 1.5);
  report("7", sensor(kGlow, "2"), 2.5);
  EXPECT_EQ(text("proxy.hall.7.sensor.glow-x.value"), "1.5");
}

TEST_F(Directory, SurvivesAddressesFromHell) {
  start();
  for (const auto* device : {"../../etc", "a.b*c", "\n", "\xff\xfe", ".", "proxy.**"}) join(device, lamp());
  join(std::string(10000, 'x'), lamp());
  EXPECT_TRUE(exists("proxy.hall.______etc.status"));
  EXPECT_TRUE(exists("proxy.hall.a_b_c.status"));
  EXPECT_TRUE(exists("proxy.hall." + std::string(64, 'x') + ".status"));
  EXPECT_EQ(json("proxy.hall.a_b_c.description")["address"], "a.b*c");
}

TEST_F(Directory, LeavesTheDevicesOfOtherIslandsToTheirProxies) {
  start();
  for (const auto pretended : {OwnerId{77}, kIsland}) {
    Message message;
    message.origin = OwnerId{77};
    message.number = 1;
    message.source = {pretended, "hall", "7"};
    message.destination = {kIsland, {}, {}};
    message.body = lamp();
    gate->send(message);
    time.run_ready();
    EXPECT_FALSE(exists("proxy.hall.7.status"));
  }
}

TEST_F(Directory, AMessageForADeviceOfTwoNetworksGoesWhereItIsReachable) {
  config.networks["garden"];
  start();
  gate->from_network("garden", Message{model::kNoOwner, 0, 0, {kIsland, "garden", "7"}, {kIsland, {}, {}}, lamp()});
  join("7", lamp());
  for (int i = 0; i < 3; ++i) {
    time.run_for(25s);
    say("7", model::KeepAlive{});
  }
  ASSERT_EQ(json("proxy.garden.7.status")["status"], "unreachable");
  Message message;
  message.destination = {kIsland, "", "7"};
  message.body = model::Opaque{"chat", {'x'}};
  gate->send(std::move(message));
  time.run_ready();
  EXPECT_EQ(hall().sent_bodies<model::Opaque>().size(), 1u);
}

}  // namespace
}  // namespace rubicon::proxy
