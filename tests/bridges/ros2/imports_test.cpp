#include "bridges/ros2/live.h"

namespace rubicon::bridges::ros2 {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Ros2Imports : public Live {
 protected:
  static constexpr const char* kBattery = "proxy.ros2-robots.robot.sensor.battery-1";
  bool is(const std::string& key, const std::string& value) {
    return until([&] { return tuple(key).find(value) != std::string::npos; });
  }
};

constexpr const char* kStrip = R"({"import": [{"topic": "/battery", "as": "robot.battery-1"}]})";
/// header 0, frame ""; voltage 12.4, temperature NaN, current, charge, capacity, design_capacity NaN, percentage 0.87,
/// status 2, health 0, technology 0, present 1; no cells; "" and "".
constexpr const char* kBatteryState =
    "0000000000000000"
    "0100000000000000"
    "66664641"
    "0000c07f0000c07f0000c07f0000c07f0000c07f"
    "52b85e3f"
    "02000001"
    "0000000000000000"
    "0100000000000000"
    "0100000000";

TEST_F(Ros2Imports, AreSensorsOfADeviceOfTheBridge) {
  Robot robot;
  bridge(kStrip);
  robot.say("pub /battery std_msgs/msg/Float64 87.5");
  EXPECT_TRUE(is(std::string(kBattery) + ".value", "87.5"));
  EXPECT_THAT(tuple(std::string(kBattery) + ".status"), HasSubstr(R"("quality":"good")"));
  EXPECT_THAT(tuple(std::string(kBattery) + ".description"), HasSubstr(R"("unit":"%")"));
  EXPECT_THAT(tuple("proxy.ros2-robots.robot.status"), HasSubstr(R"("reachable")"));
  EXPECT_THAT(tuple("proxy.ros2-robots.robot.description"), HasSubstr(R"("battery-1")"));
  EXPECT_THAT(tuple("proxy.ros2-robots.status"), HasSubstr(R"("up")"));
}

TEST_F(Ros2Imports, AreOfflineWhenTheirPublisherGoesOrIsKilledAndComeBack) {
  bridge(kStrip);
  {
    Robot robot;
    robot.say("pub /battery std_msgs/msg/Float64 87.5");
    ASSERT_TRUE(is(std::string(kBattery) + ".value", "87.5"));
    robot.say("drop /battery");
    EXPECT_TRUE(is(std::string(kBattery) + ".status", "device-offline"));
    robot.say("pub /battery std_msgs/msg/Float64 86");
    EXPECT_TRUE(is(std::string(kBattery) + ".value", "86"));
    EXPECT_TRUE(is(std::string(kBattery) + ".status", "good"));
    robot.kill();
    EXPECT_TRUE(is(std::string(kBattery) + ".status", "device-offline"));
    EXPECT_TRUE(is("proxy.ros2-robots.robot.status", "unreachable"));
    EXPECT_EQ(tuple(std::string(kBattery) + ".value"), "86") << "the last one, with its quality";
  }
  Robot again;
  again.say("pub /battery std_msgs/msg/Float64 hold 85");
  EXPECT_TRUE(is(std::string(kBattery) + ".value", "85"));
  EXPECT_TRUE(is("proxy.ros2-robots.robot.status", "\"reachable\""));
}

TEST_F(Ros2Imports, TakeTheValueOfAMessageThatTheRuleNames) {
  Robot robot;
  bridge(R"({"import": [{"topic": "/battery", "as": "robot.battery-1"}]})");
  robot.say(std::string("bytes /battery sensor_msgs/msg/BatteryState ") + kBatteryState);
  EXPECT_TRUE(is(std::string(kBattery) + ".value", "87")) << "0.87 of the robot";
  EXPECT_EQ(tuple("proxy.ros2-robots.robot.sensor.voltage-1.value"), "(none)");
}

/// A reader that asks for what is kept gets nothing from a publisher that keeps nothing.
TEST_F(Ros2Imports, AreNotGoodWhereAPublisherComesBackWithOtherQosUntilItSpeaks) {
  bridge(kStrip);
  Robot robot;
  robot.say("pub /battery std_msgs/msg/Float64 hold 87.5");
  ASSERT_TRUE(is(std::string(kBattery) + ".value", "87.5"));
  robot.say("drop /battery\noffer /battery std_msgs/msg/Float64");
  EXPECT_TRUE(is(std::string(kBattery) + ".status", "the publisher of this value is gone"));
  EXPECT_THAT(tuple(std::string(kBattery) + ".status"), HasSubstr(R"("quality":"device-offline")"));
  EXPECT_THAT(tuple("proxy.ros2-robots.robot.status"), HasSubstr(R"("reachable")"));
  robot.say("pub /battery std_msgs/msg/Float64 86");
  EXPECT_TRUE(is(std::string(kBattery) + ".value", "86"));
  EXPECT_TRUE(is(std::string(kBattery) + ".status", R"("quality":"good")"));
}

TEST_F(Ros2Imports, AreNotGoodWhereAPublisherComesBackWithAnotherType) {
  bridge(kStrip);
  Robot robot;
  robot.say("pub /battery std_msgs/msg/Float64 87.5");
  ASSERT_TRUE(is(std::string(kBattery) + ".value", "87.5"));
  robot.say("drop /battery\noffer /battery std_msgs/msg/Int64");
  const std::string why = "published as std_msgs/msg/Int64, but imported as std_msgs/msg/Float64";
  EXPECT_TRUE(is(std::string(kBattery) + ".status", why));
  EXPECT_THAT(tuple(std::string(kBattery) + ".status"), HasSubstr(R"("quality":"device-offline")"));
  EXPECT_THAT(made->status().reason, HasSubstr("/battery: " + why));
  EXPECT_TRUE(log.contains("/battery: " + why));
  robot.say("drop /battery\npub /battery std_msgs/msg/Float64 hold 86");  // said once: it may come before it is read
  EXPECT_TRUE(is(std::string(kBattery) + ".value", "86"));
  EXPECT_TRUE(is(std::string(kBattery) + ".status", R"("quality":"good")"));
  EXPECT_EQ(made->status().reason, "");
}

/// It would be imported no more after a restart, since topics of ours are not.
TEST_F(Ros2Imports, EndWhereATopicOfOursTakesTheirName) {
  bridge(R"({"import": "auto"})");
  Robot robot;
  robot.say("pub /home/wsn_1/d7/power_1 std_msgs/msg/Float64 1");
  const std::string sensor = "proxy.ros2-robots.home.sensor.analogueInput-wsn_1_d7_power_1";
  ASSERT_TRUE(is(sensor + ".status", R"("quality":"good")"));
  island.network("wsn-1");
  island.device("wsn-1.7", "Mote", {{"sensor", "power-1", "2"}});
  EXPECT_TRUE(is(sensor + ".status", "a topic of ours has its name"));
  EXPECT_THAT(tuple(sensor + ".status"), HasSubstr(R"("quality":"device-offline")"));
  EXPECT_TRUE(log.contains("/home/wsn_1/d7/power_1: a topic of ours has its name"));
  EXPECT_EQ(counter("imported-topics"), 0U);
  island.remove_device("wsn-1.7");
  EXPECT_TRUE(until([&] { return counter("imported-topics") == 1; }));
  robot.say("pub /home/wsn_1/d7/power_1 std_msgs/msg/Float64 3");
  EXPECT_TRUE(is(sensor + ".value", "3"));
  EXPECT_TRUE(is(sensor + ".status", R"("quality":"good")"));
}

/// A rule may name a topic that has a publisher of a robot beside ours.
TEST_F(Ros2Imports, OfATopicThatIsOursTooAreThoseOfRobotsAlone) {
  island.network("wsn-1");
  island.device("wsn-1.7", "Mote", {{"sensor", "power-1", "2"}, {"actuator", "lamp-1", "off"}});
  bridge(R"({"import": [{"topic": "/home/wsn_1/d7/lamp_1", "as": "robot.digitalInput-1"},
                        {"topic": "/home/wsn_1/d7/power_1", "as": "robot.power-1"}]})");
  Robot robot;
  robot.say("pub /home/wsn_1/d7/lamp_1 std_msgs/msg/Bool true");
  robot.say("pub /home/wsn_1/d7/power_1 std_msgs/msg/Float64 1");
  const std::string lamp = "proxy.ros2-robots.robot.sensor.digitalInput-1.value";
  ASSERT_TRUE(is(lamp, "on"));
  ASSERT_TRUE(is("proxy.ros2-robots.robot.sensor.power-1.value", "1"));
  island.say("wsn-1.7", {"actuator", "lamp-1", "on"});
  island.say("wsn-1.7", {"actuator", "lamp-1", "off"});
  run(300ms);
  EXPECT_EQ(tuple(lamp), "on") << "of the robot";
  EXPECT_EQ(counter("imported-messages"), 2U);
  EXPECT_EQ(counter("topics-read"), 0U) << "an import is no reader of ours";
  EXPECT_TRUE(wanted.empty());
}

TEST_F(Ros2Imports, TakeEverythingThatTheyKnowByThemselves) {
  Robot robot;
  bridge(R"({"import": "auto"})");
  robot.say(std::string("bytes /r1/battery sensor_msgs/msg/BatteryState ") + kBatteryState);
  robot.say("pub /r1/door std_msgs/msg/Bool true");
  robot.say("pub /mode std_msgs/msg/String idle");
  const std::string r1 = "proxy.ros2-robots.r1.sensor.";
  EXPECT_TRUE(is(r1 + "battery-battery_percentage.value", "87"));
  EXPECT_TRUE(is(r1 + "voltage-battery_voltage.value", "12.4"));
  EXPECT_TRUE(is(r1 + "digitalInput-door.value", "on"));
  EXPECT_TRUE(is("proxy.ros2-robots.robot.sensor.text-mode.value", "idle"));
  EXPECT_EQ(tuple(r1 + "current-battery_current.value"), "(none)") << "the robot does not measure it";
  EXPECT_THAT(tuple("proxy.ros2-robots.r1.description"), HasSubstr("voltage-battery_voltage"));
}

/// 1.5 = 0x3ff8..., -2 = 0xc000..., 0.7071067811865476 = 0x3fe6a09e667f3bcd, 1 = 0x3ff0...; a quarter turn and a half
/// one.
TEST_F(Ros2Imports, OfPosesAndDiagnosticsAreWhatTheBytesSay) {
  Robot robot;
  bridge(R"({"import": "auto"})");
  const std::string header = "00000000000000000100000000", zero8(16, '0');
  const std::string place =
      "000000000000f83f"
      "00000000000000c0" +
      zero8;
  const std::string quarter = zero8 + zero8 +
                              "cd3b7f669ea0e63f"
                              "cd3b7f669ea0e63f";
  const std::string half = zero8 + zero8 + "000000000000f03f" + zero8;
  const std::string covariance(std::size_t{36} * 16, '0');
  robot.say("bytes /r1/goal geometry_msgs/msg/PoseStamped " + header + "000000" + place + quarter);
  robot.say("bytes /r1/amcl geometry_msgs/msg/PoseWithCovarianceStamped " + header + "000000" + place + quarter +
            covariance);
  robot.say("bytes /r1/odom nav_msgs/msg/Odometry " + header + "000000" + "0100000000" + "000000" + place + half +
            covariance + std::string(std::size_t{6} * 16, '0') + covariance);
  robot.say("bytes /r1/diagnostics diagnostic_msgs/msg/DiagnosticArray " + header + "000000" + "01000000" + "02" +
            "000000" + "0400000061726d00" + "04000000686f7400" + "0100000000" + "000000" + "01000000" + "020000006100" +
            "0000" + "020000006200");
  const std::string r1 = "proxy.ros2-robots.r1.sensor.";
  for (const auto* name : {"goal", "amcl", "odom"}) {
    EXPECT_TRUE(is(r1 + "length-" + name + "_x.value", "1.5")) << name;
    EXPECT_TRUE(is(r1 + "length-" + name + "_y.value", "-2")) << name;
  }
  EXPECT_TRUE(is(r1 + "angle-goal_yaw.value", "90"));
  EXPECT_TRUE(is(r1 + "angle-amcl_yaw.value", "90"));
  EXPECT_TRUE(is(r1 + "angle-odom_yaw.value", "180"));
  EXPECT_TRUE(is(r1 + "text-diagnostics_arm.value", "error: hot"));
}

TEST_F(Ros2Imports, AreForgottenADayAfterTheirPublisherLeft) {
  bridge(R"({"import": "auto"})");
  Robot robot;
  robot.say("pub /r1/door std_msgs/msg/Bool true\npub /r1/mode std_msgs/msg/String idle");
  const std::string r1 = "proxy.ros2-robots.r1", door = r1 + ".sensor.digitalInput-door";
  ASSERT_TRUE(is(door + ".value", "on"));
  ASSERT_TRUE(is(r1 + ".sensor.text-mode.value", "idle"));
  robot.say("drop /r1/door");
  ASSERT_TRUE(is(door + ".status", "no publisher of its topic is there"));
  time.leap(24h - 1min);
  run(300ms);
  EXPECT_EQ(tuple(door + ".value"), "on");
  time.leap(1min);
  ASSERT_TRUE(is(door + ".value", "(none)"));
  for (const auto* part : {".status", ".description"}) EXPECT_EQ(tuple(door + part), "(none)") << part;
  EXPECT_THAT(tuple(r1 + ".description"), AllOf(HasSubstr("text-mode"), Not(HasSubstr("digitalInput"))));
  EXPECT_EQ(counter("imported-sensors"), 1U);
  EXPECT_EQ(tuple(r1 + ".sensor.text-mode.value"), "idle") << "it has a publisher, which may be silent for hours";
  robot.say("drop /r1/mode");
  ASSERT_TRUE(is(r1 + ".status", "unreachable"));
  time.leap(24h);
  ASSERT_TRUE(is(r1 + ".description", "(none)"));
  EXPECT_EQ(tuple(r1 + ".status"), "(none)");
  EXPECT_EQ(counter("imported-sensors"), 0U);
  robot.say("pub /r1/door std_msgs/msg/Bool false");
  EXPECT_TRUE(is(door + ".value", "off"));
  EXPECT_TRUE(is(r1 + ".status", "\"reachable\""));
}

TEST_F(Ros2Imports, ThatARuleNamesAreKept) {
  bridge(kStrip);
  Robot robot;
  robot.say("pub /battery std_msgs/msg/Float64 87.5");
  ASSERT_TRUE(is(std::string(kBattery) + ".value", "87.5"));
  robot.say("drop /battery");
  ASSERT_TRUE(is(std::string(kBattery) + ".status", "device-offline"));
  time.leap(48h);
  run(300ms);
  EXPECT_EQ(tuple(std::string(kBattery) + ".value"), "87.5");
  EXPECT_THAT(tuple("proxy.ros2-robots.robot.description"), HasSubstr("battery-1"));
}

/// Robots that come under other names each day.
TEST_F(Ros2Imports, OfRobotsThatAreGoneMakeRoomForOthers) {
  bridge(R"({"import": "auto"})");
  {
    Robot robot;
    robot.say("many 256");
    ASSERT_TRUE(until([&] { return counter("imported-topics") == 256; }));
  }
  ASSERT_TRUE(until([&] { return counter("imported-topics") == 0; }));
  Robot other;
  other.say("offer /r2/charge std_msgs/msg/Float64");
  ASSERT_TRUE(until([&] { return made->status().reason.find("1 topics of robots") != std::string::npos; }));
  time.leap(24h);
  EXPECT_TRUE(until([&] { return counter("imported-topics") == 1; }));
  EXPECT_EQ(made->status().reason, "");
}

/// With a prefix that leaves room for the keys of the device, but not for those of the sensor.
TEST_F(Ros2Imports, ThatCannotBeMadeAreNoSensorsOfTheirDevice) {
  prefix = std::string(215, 'p');
  bridge(kStrip);
  Robot robot;
  robot.say("pub /battery std_msgs/msg/Float64 87.5");
  ASSERT_TRUE(until([&] { return counter("imported-messages") == 1; }));
  robot.say("drop /battery");
  const auto device = prefix + ".ros2-robots.robot";
  ASSERT_TRUE(is(device + ".status", "unreachable"));
  EXPECT_THAT(tuple(device + ".description"), AllOf(HasSubstr("ROS 2"), Not(HasSubstr("battery-1"))));
}

TEST_F(Ros2Imports, DoNotTakeTheirOwnTopicsBack) {
  island.network("wsn-1");
  island.device("wsn-1.7", "Mote", {{"sensor", "temperature-1", "21.5"}});
  bridge(R"({"import": "auto"})");
  Robot robot;
  robot.say("pub /mode std_msgs/msg/String idle");
  ASSERT_TRUE(is("proxy.ros2-robots.robot.sensor.text-mode.value", "idle"));
  EXPECT_EQ(counter("topics"), 1U) << "the robot's own topic is not shown to robots again";
  EXPECT_EQ(counter("imported-topics"), 1U);
}

/// Each is bad, keeps the value before, and a good one heals it.
TEST_F(Ros2Imports, ThatAreWrongAreBadAndDoNoHarm) {
  Robot robot;
  bridge(kStrip);
  robot.say("pub /battery std_msgs/msg/Float64 87.5");
  ASSERT_TRUE(is(std::string(kBattery) + ".value", "87.5"));
  for (const auto* wrong : {"nan", "inf", "-inf", "150", "-1"}) {
    robot.say(std::string("pub /battery std_msgs/msg/Float64 ") + wrong);
    EXPECT_TRUE(is(std::string(kBattery) + ".status", R"("quality":"bad")")) << wrong;
    EXPECT_EQ(tuple(std::string(kBattery) + ".value"), "87.5") << wrong;
    robot.say("pub /battery std_msgs/msg/Float64 87.5");
    EXPECT_TRUE(is(std::string(kBattery) + ".status", R"("quality":"good")")) << wrong;
  }
}

/// Other layouts under our type names: too short, lengths of 4 GB, no NUL, times before 1970 and beyond.
TEST_F(Ros2Imports, SurviveMessagesOfAnotherLayout) {
  bridge(R"({"import": "auto"})");
  Robot robot;
  const char* wrong[][2] = {{"std_msgs/msg/String", "ffffffff41"},
                            {"std_msgs/msg/String", "0300000041424344"},
                            {"std_msgs/msg/String", "00000000"},
                            {"std_msgs/msg/String", "0500"},
                            {"std_msgs/msg/Float64", "00000000"},
                            {"std_msgs/msg/Bool", "ff"},
                            {"diagnostic_msgs/msg/DiagnosticArray", "000000000000000001000000ffffffff"},
                            {"diagnostic_msgs/msg/DiagnosticArray", "00000000000000000100000000000010"},
                            {"sensor_msgs/msg/BatteryState", "0000000000000000ffffff7f00"},
                            {"nav_msgs/msg/Odometry", "0000000000000000010000000000"},
                            {"sensor_msgs/msg/Temperature",
                             "00000080ffffffff"
                             "0100000000000000"
                             "0000000000803540"
                             "0000000000000000"}};
  int number = 0;
  for (const auto& [type, hex] : wrong) robot.say("bytes /wrong_" + std::to_string(number++) + " " + type + " " + hex);
  robot.say("pub /mode std_msgs/msg/String idle");
  EXPECT_TRUE(is("proxy.ros2-robots.robot.sensor.text-mode.value", "idle"));
  EXPECT_EQ(made->status().state, "up");
  EXPECT_TRUE(is("proxy.ros2-robots.robot.sensor.temperature-wrong_10.value", "21.5")) << "only its time is wrong";
  EXPECT_EQ(tuple("proxy.ros2-robots.robot.sensor.text-wrong_0.value"), "(none)");
}

class Ros2Node : public Live {
 protected:
  std::string reason() const { return made->status().reason; }
};

TEST_F(Ros2Node, HasANameForEachDistribution) {
  island.network("wsn-1");
  island.device("wsn-1.7", "Mote", {{"sensor", "temperature-1", "21.5"}});
  for (const auto* distribution : {"humble", "jazzy"}) {
    bridge();
    Robot robot(distribution);
    EXPECT_TRUE(sees(robot, "node / rubicon_6541 readers 0 writers 2")) << distribution;
    EXPECT_EQ(counter("robots"), 1U);
    EXPECT_EQ(robot.lines("node ").size(), robot.lines("node / rubicon_6541").size()) << "none is misread";
    end_bridge();
  }
}

TEST_F(Ros2Node, HasNoNameWhereBothSizesAreRead) {
  bridge();
  Robot robot("jazzy");
  ASSERT_TRUE(sees(robot, "node / rubicon_6541"));
  Robot old("humble");
  EXPECT_TRUE(until([&] { return reason().find("both sizes") != std::string::npos; })) << reason();
  Robot third("humble");
  ASSERT_TRUE(sees(third, "topic rt/diagnostics"));
  run(500ms);
  EXPECT_FALSE(third.saw("node ")) << "it would be misread";
}

TEST_F(Ros2Node, SaysThatNoOtherNodeIsThere) {
  bridge();
  EXPECT_EQ(made->status().state, "up");
  EXPECT_THAT(reason(), HasSubstr("no other node is in this domain"));
  Robot robot;
  EXPECT_TRUE(until([&] { return reason().empty(); })) << reason();
  EXPECT_EQ(made->status().peer, "ROS domain 0");
}

TEST_F(Ros2Node, IsNotSeenInAnotherDomain) {
  bridge(R"({"domain": 7})");
  Robot other("humble", 8), same("humble", 7);
  EXPECT_TRUE(sees(same, "topic rt/diagnostics"));
  EXPECT_FALSE(other.saw("topic rt/diagnostics"));
}

TEST_F(Ros2Node, NamesTwoBridgesWithOneNamespace) {
  island.network("wsn-1");
  island.device("wsn-1.7", "Mote", {{"sensor", "power-1", "1"}});
  bridge();
  Robot robot;
  ASSERT_TRUE(sees(robot, "power_1"));
  robot.say("pub /home/wsn_1/d7/power_1 std_msgs/msg/Float64 1");
  EXPECT_TRUE(until([&] { return reason().find("namespace") != std::string::npos; })) << reason();
}

TEST_F(Ros2Node, TriesAgainWhereItsInterfaceIsNotThere) {
  island.network("wsn-1");
  island.device("wsn-1.7", "Mote", {{"sensor", "power-1", "1"}});
  bridge(R"({"interfaces": "robots0"})");
  EXPECT_EQ(made->status().state, "connecting");
  EXPECT_THAT(reason(), HasSubstr("robots0"));
  ASSERT_EQ(std::system("ip link add robots0 type bridge && ip addr add 10.77.0.1/24 dev robots0 && "
                        "ip link set robots0 up multicast on"),
            0);
  EXPECT_TRUE(until([&] { return made->status().state == "up"; })) << reason();
  ASSERT_EQ(std::system("ip addr flush dev robots0 && ip link set robots0 down"), 0);
  EXPECT_TRUE(until([&] { return made->status().state == "connecting"; }));
  ASSERT_EQ(std::system("ip addr add 10.77.0.2/24 dev robots0 && ip link set robots0 up"), 0);
  EXPECT_TRUE(until([&] { return made->status().state == "up"; })) << reason();
  EXPECT_EQ(counter("topics"), 1U);
  EXPECT_EQ(counter("opened"), 2U);
  std::ignore = std::system("ip link del robots0");
}

/// Loopback alone, then an interface, which is unplugged and comes back as it was.
TEST_F(Ros2Node, FollowsTheInterfaceThatCycloneChooses) {
  const char* plug =
      "ip link add robots0 type bridge && ip addr add 10.77.0.1/24 dev robots0 && ip link set robots0 up multicast on";
  for (const auto* interfaces : {"any", "robots0"}) {
    if (interfaces == std::string("robots0")) {
      ASSERT_EQ(std::system(plug), 0);
    }
    bridge(fmt::format(R"({{"interfaces": "{}"}})", interfaces));
    ASSERT_EQ(made->status().state, "up") << reason();
    if (interfaces == std::string("any")) {
      ASSERT_EQ(std::system(plug), 0);
      EXPECT_TRUE(until([&] { return counter("opened") == 2; })) << "robots are there, not on loopback";
    }
    const auto opened = counter("opened");
    ASSERT_EQ(std::system((std::string("ip link del robots0 && ") + plug).c_str()), 0);
    EXPECT_TRUE(until([&] { return counter("opened") == opened + 1; })) << interfaces;
    end_bridge();
    std::ignore = std::system("ip link del robots0");
  }
}

TEST_F(Ros2Node, TellsItsNameNoMoreOftenThanItChanges) {
  bridge();
  Robot robot;
  ASSERT_TRUE(sees(robot, "node / rubicon_6541 readers 0 writers 1"));
  run(300ms);
  const auto told = robot.lines("node ").size();
  for (int i = 0; i < 3; ++i) {
    Robot other;
    robot.say(fmt::format("offer /x{} std_msgs/msg/Float64", i));
    ASSERT_TRUE(until([&] { return counter("robots") == 2; }));
    run(300ms);
  }
  EXPECT_EQ(robot.lines("node ").size(), told);
}

TEST_F(Ros2Node, HasRoomForTenThousandTopicsOfOthers) {
  const auto began = loop.scheduler().now();
  bridge(R"({"import": "auto"})");
  Robot robot;
  robot.say("many 10000");
  EXPECT_TRUE(until([&] { return counter("imported-topics") == 256; }));
  EXPECT_TRUE(until([&] { return reason().find("9744 topics of robots are not imported") != std::string::npos; }))
      << reason();
  EXPECT_LE(counter("import-looks"), static_cast<std::uint64_t>((loop.scheduler().now() - began) / 100ms) + 1)
      << "each goes through all of them";
}

}  // namespace
}  // namespace rubicon::bridges::ros2
