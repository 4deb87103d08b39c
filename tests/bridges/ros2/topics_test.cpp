#include <filesystem>

#include "bridges/ros2/diagnostics.h"
#include "bridges/ros2/live.h"
#include "bridges/ros2/names.h"

namespace rubicon::bridges::ros2 {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kTemperature = "/home/wsn_1/d7/temperature_1";
constexpr const char* kLamp = "/home/wsn_1/d7/lamp_1";

class Ros2Topics : public Live {
 protected:
  void start(const std::string& options = "{}") {
    island.network("wsn-1");
    island.device("wsn-1.7", "Mote", {{"sensor", "temperature-1", "21.5"}, {"actuator", "lamp-1", "off"}});
    bridge(options);
  }
  void heat(const std::string& value, const std::string& quality = "good") {
    island.say("wsn-1.7", {"sensor", "temperature-1", value, quality});
  }
  bool is_wanted() const { return wanted.contains("proxy.wsn-1.7.sensor.temperature-1.value"); }
};

TEST_F(Ros2Topics, AreInTheListWithTheirTypesAndQos) {
  Robot robot;
  start();
  EXPECT_TRUE(sees(robot, "topic rt/home/wsn_1/d7/temperature_1 sensor_msgs::msg::dds_::Temperature_ volatile"));
  EXPECT_TRUE(sees(robot, "topic rt/home/wsn_1/d7/lamp_1 std_msgs::msg::dds_::Bool_ kept"));
  EXPECT_TRUE(sees(robot, "topic rt/diagnostics diagnostic_msgs::msg::dds_::DiagnosticArray_ volatile"));
  EXPECT_TRUE(sees(robot, "participant enclave=/;"));
  EXPECT_FALSE(robot.saw("/set")) << "commands: no";
}

TEST_F(Ros2Topics, AReaderWakesTheSensorAndTheLastOneLetsItSleep) {
  start();
  Robot robot, other;
  ASSERT_TRUE(sees(robot, kTemperature));
  ASSERT_TRUE(sees(other, kTemperature));
  EXPECT_FALSE(is_wanted()) << "nobody reads";
  robot.say(std::string("echo ") + kTemperature + " sensor_msgs/msg/Temperature");
  ASSERT_TRUE(until([&] { return is_wanted(); }));
  other.say(std::string("echo ") + kTemperature + " sensor_msgs/msg/Temperature best");
  const auto reading = std::string(kTemperature) + " 22.5 7";
  EXPECT_TRUE(until([&] {
    heat("22.5");
    return robot.saw(reading) && other.saw(reading);
  })) << "one of them reads best effort";
  robot.say(std::string("stop ") + kTemperature);
  ASSERT_TRUE(sees(robot, "did stop"));
  run(100ms);
  EXPECT_TRUE(is_wanted()) << "the other one still reads";
  other.kill();
  EXPECT_TRUE(until([&] { return !is_wanted(); })) << "a killed reader is none";
}

TEST_F(Ros2Topics, EachReadingOfATurnArrives) {
  start();
  Robot robot;
  ASSERT_TRUE(sees(robot, kTemperature));
  robot.say(std::string("echo ") + kTemperature + " sensor_msgs/msg/Temperature");
  ASSERT_TRUE(until([&] { return is_wanted(); }));
  for (const auto* value : {"22", "22", "23"}) {
    heat(value);
    run(1ms);
  }
  const auto lines = [&] { return robot.lines(std::string(kTemperature) + " 2"); };
  EXPECT_TRUE(until([&] { return lines().size() >= 3; }));
  EXPECT_EQ(lines().size(), 3U);
}

TEST_F(Ros2Topics, ALateReaderGetsTheStateOfNowAndNoOldOne) {
  start();
  Robot robot;
  ASSERT_TRUE(sees(robot, kLamp));
  robot.say(std::string("echo ") + kLamp + " std_msgs/msg/Bool");
  EXPECT_TRUE(sees(robot, std::string(kLamp) + " false"));
  island.say("wsn-1.7", {"actuator", "lamp-1", "on"});
  EXPECT_TRUE(sees(robot, std::string(kLamp) + " true"));
  island.say("wsn-1.7", {"actuator", "lamp-1", "on", "device-offline"});
  run(200ms);
  Robot late;
  ASSERT_TRUE(sees(late, kLamp));
  late.say(std::string("echo ") + kLamp + " std_msgs/msg/Bool");
  ASSERT_TRUE(sees(late, "did echo"));
  run(500ms);
  EXPECT_THAT(late.lines(std::string(kLamp) + " t"), IsEmpty()) << "it is not a value of now";
  island.say("wsn-1.7", {"actuator", "lamp-1", "on"});
  EXPECT_TRUE(sees(late, std::string(kLamp) + " true"));
}

TEST_F(Ros2Topics, WhatIsNotGoodIsNotPublishedAsFresh) {
  start();
  Robot robot;
  ASSERT_TRUE(sees(robot, kTemperature));
  robot.say(std::string("echo ") + kTemperature + " sensor_msgs/msg/Temperature");
  robot.say("echo /diagnostics diagnostic_msgs/msg/DiagnosticArray");
  ASSERT_TRUE(until([&] { return is_wanted(); }));
  heat("30", "stale");
  EXPECT_TRUE(sees(robot, "[rubicon: home/wsn_1/d7 3 temperature-1: stale"));
  EXPECT_TRUE(sees(robot, "temperature-1=30 Cel (stale)"));
  EXPECT_FALSE(robot.saw(std::string(kTemperature) + " 30"));
  heat("31");
  EXPECT_TRUE(sees(robot, std::string(kTemperature) + " 31"));
  EXPECT_TRUE(sees(robot, "[rubicon: home/wsn_1 0 up"));
  EXPECT_TRUE(sees(robot, "[rubicon: home/wsn_1/d7 0 reachable"));
}

/// A message as DDS-XTypes 1.3, 7.4.1 (XCDR1, little-endian) has it, without the four octets before it. The values are
/// IEEE 754: 21.5 = 0x4035800000000000, 0.55 = 0x3fe199999999999a, 0.87 = 0x3f5eb852 (float), 59.27 =
/// 0x404da28f5c28f5c3, 15.2 = 0x402e666666666666, NaN = 0x7fc00000 and 0x7ff8000000000000, 1.5 = 0x3fc00000 (float),
/// 101325 = 0x40f8bcd000000000.
struct Golden {
  Described point;
  const char *topic, *type;
  std::string bytes;
};

/// 1767225600 s = 0x6955b900, 250000000 ns = 0x0ee6b280, frame_id `7` of 2 octets with its NUL.
const std::string kHeader = "00b9556980b2e60e020000003700";

std::vector<Golden> all_golden() {
  const std::string zero8(16, '0'), nan4 = "0000c07f";
  return {
      {{"sensor", "temperature-1", "21.5"},
       "temperature_1",
       "sensor_msgs/msg/Temperature",
       kHeader + "0000" + "0000000000803540" + zero8},
      {{"sensor", "humidity-1", "55"},
       "humidity_1",
       "sensor_msgs/msg/RelativeHumidity",
       kHeader + "0000" + "9a9999999999e13f" + zero8},
      {{"sensor", "light-1", "21.5"},
       "light_1",
       "sensor_msgs/msg/Illuminance",
       kHeader + "0000" + "0000000000803540" + zero8},
      {{"sensor", "airPressure-1", "101325"},
       "airPressure_1",
       "sensor_msgs/msg/FluidPressure",
       kHeader + "0000" + "00000000d0bcf840" + zero8},
      {{"sensor", "distance-1", "1.5"},
       "distance_1",
       "sensor_msgs/msg/Range",
       kHeader + "00" + "00" + "00000000" + "00000000" + "00000000" + "0000c03f" + "00000000"},
      {{"sensor", "battery-1", "87"},
       "battery_1",
       "sensor_msgs/msg/BatteryState",
       kHeader + "0000" + nan4 + nan4 + nan4 + nan4 + nan4 + nan4 + "52b85e3f" + "00000001" + "00000000" + "00000000" +
           "0100000000" + "000000" + "0100000000"},
      {{"sensor", "power-1", "21.5"}, "power_1", "std_msgs/msg/Float64", "0000000000803540"},
      {{"sensor", "windForce-1", "7"}, "windForce_1", "std_msgs/msg/Int64", "0700000000000000"},
      {{"actuator", "lamp-1", "on"}, "lamp_1", "std_msgs/msg/Bool", "01"},
      {{"sensor", "text-1", "hi"}, "text_1", "std_msgs/msg/String", "03000000686900"},
  };
}

TEST_F(Ros2Topics, HaveTheBytesOfThePage) {
  const auto golden = all_golden();
  std::vector<Described> points{{"sensor", "latitude-1", "59.27"}, {"sensor", "longitude-1", "15.2"}};
  for (const auto& one : golden) points.push_back(one.point);
  island.network("wsn-1");
  island.device("wsn-1.7", "Mote", points);
  bridge();
  Robot robot;
  const std::string place = "/home/wsn_1/d7/";
  ASSERT_TRUE(sees(robot, "topic rt" + place + "text_1"));
  ASSERT_TRUE(sees(robot, "topic rt" + place + "position_1 sensor_msgs::msg::dds_::NavSatFix_"));
  EXPECT_FALSE(robot.saw(place + "latitude_1")) << "both are one topic";
  for (const auto& one : golden)
    robot.say("raw " + place + one.topic + " " + one.type + " " + std::to_string(one.bytes.size() / 2));
  robot.say("raw " + place + "position_1 sensor_msgs/msg/NavSatFix 120");
  ASSERT_TRUE(until([&] { return wanted.size() == golden.size() + 2; })) << wanted.size();
  SetOptions options;
  options.user_time = WallTime(std::chrono::microseconds(1'767'225'600'250'000));
  const std::string device = "proxy.wsn-1.7.";
  for (const auto& point : points)
    ASSERT_TRUE(island.space.set(device + point.kind + "." + point.id + ".value", point.value, options));
  for (const auto& one : golden) EXPECT_TRUE(sees(robot, place + one.topic + " " + one.bytes)) << one.bytes;
  // No status and no service known, 59.27, 15.2, no altitude, no covariance.
  EXPECT_TRUE(sees(robot, place + "position_1 " + kHeader + "0000" + "0000" + "000000000000" + "c3f5285c8fa24d40" +
                              "6666666666662e40" + "000000000000f87f" + std::string(144, '0')));
}

TEST_F(Ros2Topics, GoWithTheirPoints) {
  start();
  Robot robot;
  ASSERT_TRUE(sees(robot, kTemperature));
  EXPECT_EQ(counter("topics"), 2U);
  robot.say(std::string("echo ") + kTemperature + " sensor_msgs/msg/Temperature");
  ASSERT_TRUE(until([&] { return is_wanted(); }));
  island.remove_device("wsn-1.7");
  EXPECT_TRUE(until([&] { return counter("topics") == 0; }));
  island.device("wsn-1.7", "Mote", {{"sensor", "temperature-1", "25"}});
  EXPECT_TRUE(until([&] { return counter("topics") == 1; }));
  EXPECT_TRUE(until([&] { return counter("topics-read") == 1; })) << "the reader is still there";
}

/// What the islands of one ecology are called and what their keys are decides; who came first does not.
TEST_F(Ros2Topics, ThatWantOneNameHaveANumberOfTheirIdAndNoneHasTheName) {
  const std::string wanted = "/home/a_b/d7/lamp_1";
  const auto lamp = [](const std::string& network) { return "proxy." + network + ".7.actuator.lamp-1"; };
  const auto name_of = [&](const std::string& network) { return distinct_name(wanted, "6541:" + lamp(network)); };
  for (const auto& [first, second] : {std::pair<std::string, std::string>{"a-b", "a_b"}, {"a_b", "a-b"}}) {
    bridge(R"({"commands": "yes"})");
    Robot robot;
    for (const auto& network : {first, second}) {
      island.network(network);
      island.device(network + ".7", "Lamp", {{"actuator", "lamp-1", "off"}});
      if (network == first) {
        ASSERT_TRUE(sees(robot, "topic rt" + wanted + "/outcome")) << "it is alone";
      }
    }
    ASSERT_TRUE(sees(robot, "gone rt" + wanted)) << "who meant the one must not switch the other";
    for (const auto& network : {second, first}) {
      ASSERT_TRUE(sees(robot, "topic rt" + name_of(network) + "/outcome")) << network;
      robot.say("pub " + name_of(network) + "/set std_msgs/msg/Bool true");
      ASSERT_TRUE(until([&] { return !island.sets.empty() && island.sets.back().key == lamp(network) + ".command"; }));
    }
    const auto& status = made->status();
    EXPECT_EQ(status.reason, wanted + " is wanted by 6541:" + lamp("a-b") + " and 6541:" + lamp("a_b") +
                                 ": each has a number behind its name");
    ASSERT_EQ(status.findings.size(), 1U);
    EXPECT_EQ(status.findings[0].first, "ros-names-clash");
    EXPECT_TRUE(log.contains("6541:" + lamp(first) + " is shown as " + name_of(first)));
    Robot later;
    ASSERT_TRUE(sees(later, "topic rt" + name_of(first)));
    island.remove_device(first + ".7");
    ASSERT_TRUE(sees(later, "topic rt" + wanted + "/outcome")) << "the other one is alone";
    EXPECT_EQ(made->status().reason, "");
    island.remove_device(second + ".7");
    island.sets.clear();
    end_bridge();
  }
}

TEST_F(Ros2Topics, BeyondTheirMostAreCountedOnceAndComeWhereThereIsRoom) {
  island.network("wsn-1");
  std::vector<Described> points;
  for (int i = 1; i <= 100; ++i) points.push_back({"sensor", fmt::format("power-{}", i), "1"});
  for (int i = 1; i <= 5; ++i) island.device(fmt::format("wsn-1.{}", i), "Meter", points);
  island.device("wsn-1.6", "More", {{"sensor", "power-1", "1"}, {"sensor", "power-2", "1"}});
  bridge();
  const auto left_out = [this] { return made->status().reason; };
  EXPECT_TRUE(until([&] { return left_out().find("2 points are not shown") != std::string::npos; })) << left_out();
  island.device("wsn-1.6", "Renamed", {{"sensor", "power-1", "1"}, {"sensor", "power-2", "1"}});
  run(300ms);
  EXPECT_THAT(left_out(), HasSubstr("2 points are not shown"));
  island.remove_device("wsn-1.5");
  EXPECT_TRUE(until([&] { return counter("topics") == 402; }));
  EXPECT_THAT(left_out(), ::testing::Not(HasSubstr("not shown")));
}

TEST_F(Ros2Topics, AreAsManyAsThePageSays) {
  island.network("wsn-1");
  std::vector<Described> points;
  for (int i = 1; i <= 100; ++i) points.push_back({"sensor", fmt::format("power-{}", i), "1"});
  for (int i = 1; i <= 100; ++i) island.device(fmt::format("wsn-1.{}", i), "Meter", points);
  bridge(R"({"patterns": ["proxy.**"]})");
  Robot robot;
  EXPECT_TRUE(until([&] { return robot.lines("topic rt/home/wsn_1/").size() == 10'000; }))
      << robot.lines("topic rt/home/wsn_1/").size();
  EXPECT_EQ(made->status().reason, "");
}

TEST_F(Ros2Topics, OfAnIslandThatIsAwaySayWhy) {
  TownIsland other(ecology, loop.scheduler(), OwnerId(6542), "lab");
  other.network("knx");
  other.device("knx.1", "Window", {{"sensor", "digitalInput-1", "on"}});
  start(R"({"patterns": ["proxy.**"], "diagnostics": "1h"})");
  Robot robot;
  ASSERT_TRUE(sees(robot, "/lab/knx/d1/digitalInput_1"));
  robot.say("echo /diagnostics diagnostic_msgs/msg/DiagnosticArray");
  EXPECT_TRUE(sees(robot, "[rubicon: lab/knx/d1 0 reachable"));
  island.network("wsn-1", "down");
  EXPECT_TRUE(sees(robot, "[rubicon: home/wsn_1 2 down")) << "it does not wait for an hour";
  ecology.cut(OwnerId(6542), OwnerId(70000));
  EXPECT_TRUE(sees(robot, "[rubicon: lab/knx/d1 1 its island is not there"));
  ecology.mend(OwnerId(6542), OwnerId(70000));
  EXPECT_TRUE(until([&] { return robot.lines("[rubicon: lab/knx/d1 0 reachable").size() >= 2; }));
}

TEST_F(Ros2Topics, OfAnIslandThatDoesNotComeBackGoAfterAWeek) {
  auto other = std::make_unique<TownIsland>(ecology, loop.scheduler(), OwnerId(6542), "lab");
  other->network("knx");
  other->device("knx.1", "Window", {{"sensor", "digitalInput-1", "on"}});
  start(R"({"patterns": ["proxy.**"], "diagnostics": "1h"})");
  Robot robot;
  ASSERT_TRUE(sees(robot, "topic rt/lab/knx/d1/digitalInput_1"));
  robot.say("echo /diagnostics diagnostic_msgs/msg/DiagnosticArray");
  ASSERT_TRUE(sees(robot, "[rubicon: lab/knx/d1 0 reachable"));
  other.reset();
  ASSERT_TRUE(sees(robot, "[rubicon: lab/knx/d1 1 its island is not there"));
  time.leap(6 * 24h);
  run(300ms);
  EXPECT_EQ(counter("topics"), 3U);
  time.leap(25h);
  EXPECT_TRUE(until([&] { return counter("topics") == 2; }));
  EXPECT_EQ(counter("devices"), 1U);
  EXPECT_TRUE(sees(robot, "gone rt/lab/knx/d1/digitalInput_1"));
  EXPECT_TRUE(sees(robot, "topic rt/home/wsn_1/d7/lamp_1"));
  time.leap(1h);
  const auto is_of_home_alone = [](const auto& line) { return line.find("lab/") == line.npos; };
  EXPECT_TRUE(until([&] {
    const auto all = robot.lines("[rubicon: home/wsn_1/d7 ");
    return std::any_of(all.begin(), all.end(), is_of_home_alone);
  })) << "the diagnostics of all devices";
}

/// Texts of 1 kB, 1,600 of them.
TEST_F(Ros2Topics, AreToldOfInMessagesOfBoundedSize) {
  island.network("wsn-1");
  std::vector<Described> points;
  for (int i = 1; i <= 40; ++i) points.push_back({"sensor", fmt::format("text-{}", i), std::string(1000, 'x')});
  for (int i = 1; i <= 40; ++i) island.device(fmt::format("wsn-1.{}", i), "Texts", points);
  bridge(R"({"patterns": ["proxy.**"], "diagnostics": "1h"})");
  Robot robot;
  ASSERT_TRUE(sees(robot, "topic rt/diagnostics"));
  robot.say("echo /diagnostics diagnostic_msgs/msg/DiagnosticArray");
  const auto messages = [&] { return robot.lines("[rubicon: home/wsn_1/d"); };
  const auto told = [&] {
    std::size_t devices = 0;
    for (const auto& line : messages()) {
      for (auto at = line.find("/wsn_1/d"); at != line.npos; at = line.find("/wsn_1/d", at + 1)) ++devices;
    }
    return devices;
  };
  ASSERT_TRUE(until([&] { return told() == 40; })) << told();
  for (auto& point : points) {
    point.quality = "stale";
    for (int i = 1; i <= 40; ++i) island.say(fmt::format("wsn-1.{}", i), point);
  }
  EXPECT_TRUE(until([&] { return told() >= 80; })) << told();
  EXPECT_GE(messages().size(), 4U);
  for (const auto& line : messages()) EXPECT_LE(line.size(), Diagnostics::kMaxMessage);
  EXPECT_THAT(messages().front(), HasSubstr(std::string(200, 'x') + "... (good)"));
}

TEST_F(Ros2Topics, LeaveOutPropertiesAndWhatTheRightsForbid) {
  judge->replace(rights::Rights({support::rule("bridge:robots", {support::Right::kRead}, {"proxy.*.*.actuator.**"})}));
  start();
  Robot robot;
  EXPECT_TRUE(sees(robot, kLamp));
  EXPECT_FALSE(robot.saw(kTemperature));
}

TEST_F(Ros2Topics, DoNotWakeWhatTheRightsForbidToWake) {
  judge->replace(rights::Rights({support::rule("bridge:robots", {support::Right::kRead})}));
  start();
  Robot robot;
  ASSERT_TRUE(sees(robot, kTemperature));
  robot.say(std::string("echo ") + kTemperature + " sensor_msgs/msg/Temperature");
  EXPECT_TRUE(until([&] { return counter("topics-read") == 1; }));
  run(100ms);
  EXPECT_FALSE(is_wanted());
  heat("22");
  EXPECT_TRUE(sees(robot, std::string(kTemperature) + " 22 7")) << "what others have sampled";
}

/// A bridge beside two islands, and a robot that is killed and started again.
TEST_F(Ros2Topics, OfTwoIslandsAreShownToARobotThatComesBack) {
  alone = true;
  TownIsland other(ecology, loop.scheduler(), OwnerId(6542), "lab");
  other.network("knx");
  other.device("knx.1", "Window", {{"sensor", "digitalInput-1", "on"}});
  start(R"({"commands": "yes", "import": [{"topic": "/battery", "as": "robot.battery-1"}]})");
  for (const auto* charge : {"80", "79"}) {
    Robot robot;
    ASSERT_TRUE(sees(robot, "/lab/knx/d1/digitalInput_1"));
    ASSERT_TRUE(sees(robot, std::string(kLamp) + "/outcome"));
    robot.say("echo /lab/knx/d1/digitalInput_1 std_msgs/msg/Bool");
    robot.say(std::string("echo ") + kTemperature + " sensor_msgs/msg/Temperature");
    robot.say(std::string("pub ") + kLamp + "/set std_msgs/msg/Bool true");
    robot.say(std::string("pub /battery std_msgs/msg/Float64 ") + charge);
    EXPECT_TRUE(sees(robot, "/lab/knx/d1/digitalInput_1 true"));
    EXPECT_TRUE(until([&] { return is_wanted() && !island.sets.empty(); }));
    EXPECT_TRUE(until([&] { return tuple("proxy.ros2-robots.robot.sensor.battery-1.value") == charge; }));
    island.sets.clear();
    robot.kill();
    EXPECT_TRUE(until([&] { return !is_wanted(); }));
    const auto status = [&] { return tuple("proxy.ros2-robots.robot.sensor.battery-1.status"); };
    EXPECT_TRUE(until([&] { return status().find("device-offline") != std::string::npos; }));
  }
  EXPECT_TRUE(other.sets.empty());
}

class Ros2Commands : public Ros2Topics {
 protected:
  bool is_set(const std::string& value) {
    return until([&] { return !island.sets.empty() && island.sets.back().value == value; });
  }
};

TEST_F(Ros2Commands, AreTakenAndAnswered) {
  start(R"({"commands": "yes"})");
  Robot robot;
  ASSERT_TRUE(sees(robot, std::string(kLamp) + "/outcome"));
  robot.say(std::string("echo ") + kLamp + "/outcome std_msgs/msg/String");
  robot.say(std::string("pub ") + kLamp + "/set std_msgs/msg/Bool true");
  ASSERT_TRUE(is_set("on"));
  EXPECT_EQ(island.sets.back().key, "proxy.wsn-1.7.actuator.lamp-1.command");
  EXPECT_EQ(island.sets.back().asker, "bridge:robots");
  island.report("wsn-1.7", {"actuator", "lamp-1", "on"}, "confirmed");
  EXPECT_TRUE(sees(robot, R"({"state":"confirmed")"));
  EXPECT_THAT(audit->lines, ElementsAre("bridge:robots set proxy.wsn-1.7.actuator.lamp-1.command: accepted"));
}

TEST_F(Ros2Commands, NeedTheRightsOfTheBridgeToo) {
  judge->replace(rights::Rights({support::rule("everybody", {support::Right::kRead, support::Right::kDemand})}));
  start(R"({"commands": "yes"})");
  Robot robot;
  ASSERT_TRUE(sees(robot, std::string(kLamp) + "/outcome"));
  robot.say(std::string("echo ") + kLamp + "/outcome std_msgs/msg/String");
  robot.say(std::string("pub ") + kLamp + "/set std_msgs/msg/Bool true");
  EXPECT_TRUE(sees(robot, R"({"state":"refused")"));
  EXPECT_THAT(island.sets, IsEmpty());
}

TEST_F(Ros2Commands, OfAFloodTheNewestIsExecutedAndTheOthersAreCounted) {
  start(R"({"commands": "yes"})");
  Robot robot;
  ASSERT_TRUE(sees(robot, std::string(kLamp) + "/outcome"));
  std::string flood;
  for (int i = 0; i < 2000; ++i) flood += std::string("pub ") + kLamp + "/set std_msgs/msg/Bool true\n";
  robot.say(flood + "pub " + kLamp + "/set std_msgs/msg/Bool false");
  ASSERT_TRUE(until([&] {
    if (!island.sets.empty() && island.sets.back().value == "on")
      island.report("wsn-1.7", {"actuator", "lamp-1", "on"}, "confirmed");
    return !island.sets.empty() && island.sets.back().value == "off";
  }));
  EXPECT_GE(counter("commands-superseded") + island.sets.size(), counter("commands"));
  EXPECT_LT(island.sets.size(), 500U) << "at most one in 20 ms";
}

/// Another vendor: a subscriber and a publisher of Fast DDS, which rmw_fastrtps uses.
TEST_F(Ros2Topics, AndImportsWorkWithFastDds) {
  const std::string program = RUBICON_BINARY_DIR "/bin/fast-robot";
  if (!std::filesystem::exists(program)) GTEST_SKIP() << "built without Fast DDS (libfastrtps-dev)";
  island.network("wsn-1");
  island.device("wsn-1.7", "Mote", {{"sensor", "temperature-1", "21.5"}, {"sensor", "power-1", "40"}});
  bridge(R"({"import": "auto"})");
  Robot robot({program, kTemperature, "/home/wsn_1/d7/power_1"});
  ASSERT_TRUE(until([&] { return wanted.size() == 2; })) << "its readers are demand";
  EXPECT_TRUE(until([&] {
    heat("22.5");
    island.say("wsn-1.7", {"sensor", "power-1", "41"});
    return robot.saw("temperature 22.5 7") && robot.saw("power 41");
  }));
  const std::string fast = "proxy.ros2-robots.fast.sensor.";
  EXPECT_TRUE(until([&] { return tuple(fast + "temperature-motor.value") == "61.5"; }));
  EXPECT_TRUE(until([&] { return tuple(fast + "analogueInput-load.value") == "0.5"; }));
  EXPECT_EQ(counter("robots"), 1U);
  robot.kill();
  EXPECT_TRUE(until([&] { return wanted.empty(); })) << "its lease ended";
}

}  // namespace
}  // namespace rubicon::bridges::ros2
