#include "bridges/ros2/names.h"

#include <gtest/gtest.h>

#include "bridges/ros2/graph.h"

namespace rubicon::bridges::ros2 {
namespace {

TEST(Ros2Names, FollowTheKeysOfPoints) {
  EXPECT_EQ(ros_name("home", "proxy.wsn-1.7.sensor.temperature-1"), "/home/wsn_1/d7/temperature_1");
  EXPECT_EQ(ros_name("home", "proxy.dummy-rooms.living.actuator.lamp-1"), "/home/dummy_rooms/living/lamp_1");
  EXPECT_EQ(ros_name("Villa Öst", "proxy.knx.1_4_6.property.interval-1"), "/Villa_st/knx/d1_4_6/interval_1");
}

TEST(Ros2Names, HaveTokensThatRosTakesAndShows) {
  EXPECT_EQ(token("1-4-6"), "d1_4_6");
  EXPECT_EQ(token("_hidden"), "d_hidden");
  EXPECT_EQ(token("a--b__c"), "a_b_c");
  EXPECT_EQ(token(""), "d");
  EXPECT_EQ(token("\xff\xfe"), "d_");
}

TEST(Ros2Names, OfAnyKeyAreNamesOfRos) {
  const std::string part(60, '9');
  const auto name = ros_name(std::string(300, '-'), "p." + part + "." + part + ".sensor." + part);
  EXPECT_TRUE(is_ros_name(name + "/outcome")) << name;
  const auto long_name = ros_name(std::string(228, 'x'), "p.abcdef.1.sensor.a-1");
  EXPECT_TRUE(is_ros_name(long_name)) << long_name;
}

TEST(Ros2Names, AreCheckedAsRosDoes) {
  EXPECT_TRUE(is_ros_name("/battery_state"));
  EXPECT_TRUE(is_ros_name("/r1/imu/x9"));
  for (const auto* bad : {"", "/", "x", "/a/", "//a", "/a//b", "/9a", "/a-b", "/a b", "/\xc3\xa9"})
    EXPECT_FALSE(is_ros_name(bad)) << bad;
  EXPECT_TRUE(is_ros_name("/" + std::string(246, 'a')));
  EXPECT_FALSE(is_ros_name("/" + std::string(1000, 'a')));
}

TEST(Ros2Names, AreOtherOnesForDds) {
  EXPECT_EQ(dds_topic("/home/x"), "rt/home/x");
  EXPECT_EQ(topic_of_dds("rt/home/x"), "/home/x");
  EXPECT_EQ(topic_of_dds("rq/add_twoRequest"), std::nullopt) << "a service";
  EXPECT_EQ(topic_of_dds("rubicon_frames"), std::nullopt);
  EXPECT_EQ(topic_of_dds("rt/" + std::string(1000, 'a')), std::nullopt);
  EXPECT_EQ(type_of_dds("sensor_msgs::msg::dds_::Temperature_"), "sensor_msgs/msg/Temperature");
  EXPECT_EQ(type_of_dds("a::srv::dds_::B_Request_"), std::nullopt);
  EXPECT_EQ(type_of_dds("::msg::dds_::_"), std::nullopt);
}

TEST(Ros2Names, OfRobotsBecomePartsOfKeys) {
  EXPECT_EQ(import_place("/battery_state").device, "robot");
  EXPECT_EQ(import_place("/battery_state").instance, "battery_state");
  EXPECT_EQ(import_place("/r1/imu/temperature").device, "r1");
  EXPECT_EQ(import_place("/r1/imu/temperature").instance, "imu_temperature");
  EXPECT_EQ(import_place("/" + std::string(200, 'a')).instance.size(), 100U);
}

/// FNV-1a of "a" is e40c292c (Internet draft draft-eastlake-fnv, test vectors).
TEST(Ros2Names, ThatClashHaveANumberOfTheirIdAlone) {
  EXPECT_EQ(distinct_name("/home/x", "a"), "/home/x_e40c292c");
  EXPECT_NE(distinct_name("/home/x", "6541:proxy.a-b"), distinct_name("/home/x", "6541:proxy.a_b"));
  const auto longest = ros_name(std::string(300, 'x'), "p.a.1.sensor.a-1");
  EXPECT_TRUE(is_ros_name(distinct_name(longest, "a") + "/outcome")) << longest.size();
}

TEST(Ros2Graph, FindsTheDistributionOfTheOthers) {
  EXPECT_EQ(gids_for(Distribution::kAuto, false, false), Gids::kNone) << "nobody is there who could misread it";
  EXPECT_EQ(gids_for(Distribution::kAuto, false, true), Gids::k24);
  EXPECT_EQ(gids_for(Distribution::kAuto, true, false), Gids::k16);
  EXPECT_EQ(gids_for(Distribution::kAuto, true, true), Gids::kNone) << "one of them would misread it";
  EXPECT_EQ(gids_for(Distribution::kHumble, true, false), Gids::k24);
  EXPECT_EQ(gids_for(Distribution::kJazzy, false, true), Gids::k16);
  EXPECT_EQ(gids_for(Distribution::kNone, true, false), Gids::kNone);
}

TEST(Ros2Graph, ReadsUserData) {
  EXPECT_EQ(user_datum("enclave=/;", "enclave"), "/");
  EXPECT_EQ(user_datum("a=1;typehash=RIHS01_00;", "typehash"), "RIHS01_00");
  EXPECT_EQ(user_datum("typehashes=1;", "typehash"), std::nullopt);
  EXPECT_EQ(user_datum("enclave", "enclave"), std::nullopt);
  EXPECT_EQ(user_datum("", "enclave"), std::nullopt);
}

}  // namespace
}  // namespace rubicon::bridges::ros2
