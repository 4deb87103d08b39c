#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "support/folder.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using testing::HasSubstr;

/// The real programs with a bridge, and a process that does what rmw does (tests/bridges/ros2/robot).
class DaemonWithRobots : public testing::Test {
 protected:
  void SetUp() override {
    if (!own_network_.entered()) GTEST_SKIP() << own_network_.reason();
  }
  std::string write(const std::string& more) {
    auto file = folder_.path() + "/home.yaml";
    std::ofstream(file)
        << "island: {id: 6541, name: home}\n"
           "networks: {dummy-1: {type: dummy, simulate: {room: {name: Room, actuators: {lamp-1: {value: off}}}}}}\n"
        << more;
    return file;
  }

  PrivateNetwork own_network_;
  const Folder folder_;
  static constexpr const char* kLamp = "/home/dummy_1/room/lamp_1";
  const std::vector<std::string> robot_{RUBICON_BINARY_DIR "/bin/ros-robot", "0", "humble", "1000"};
};

TEST_F(DaemonWithRobots, ShowsTakesCommandsAndEndsByAReload) {
  Process daemon({kDaemon, "run", write("bridges: {robots: {type: ros2, commands: yes}}\n")});
  Process robot(robot_);
  ASSERT_TRUE(robot.line_with(std::string("topic rt") + kLamp + "/outcome"));
  robot.write(std::string("echo ") + kLamp + " std_msgs/msg/Bool\n");
  ASSERT_TRUE(robot.line_with(std::string(kLamp) + " false"));
  robot.write(std::string("pub ") + kLamp + "/set std_msgs/msg/Bool true\n");
  ASSERT_TRUE(robot.line_with(std::string(kLamp) + " true"));
  write("");
  daemon.signal(SIGHUP);
  ASSERT_TRUE(robot.line_with(std::string("gone rt") + kLamp)) << "the bridge was removed";
  write("bridges: {robots: {type: ros2, namespace: other}}\n");
  daemon.signal(SIGHUP);
  ASSERT_TRUE(robot.line_with("topic rt/other/dummy_1/room/lamp_1"));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.exit_code(), 0) << daemon.errors();
}

TEST_F(DaemonWithRobots, TheProgramAloneShowsTheIslandToo) {
  Process daemon({kDaemon, "run", write("")});
  Process bridge({RUBICON_BINARY_DIR "/bin/rubicon", "ros2", "--commands", "yes"});
  Process robot(robot_);
  ASSERT_TRUE(robot.line_with(std::string("topic rt") + kLamp));
  robot.write(std::string("pub ") + kLamp + "/set std_msgs/msg/Bool true\n");
  robot.write(std::string("echo ") + kLamp + " std_msgs/msg/Bool\n");
  ASSERT_TRUE(robot.line_with(std::string(kLamp) + " true"));
  bridge.signal(SIGTERM);
  EXPECT_EQ(bridge.exit_code(), 0) << bridge.errors();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.exit_code(), 0) << daemon.errors();
}

TEST_F(DaemonWithRobots, NamesWhatIsWrongWithItsOptions) {
  const auto wrong = run_to_end({kDaemon, "check", write("bridges: {robots: {type: ros2, domain: 233}}\n")});
  EXPECT_THAT(wrong.errors, HasSubstr("home.yaml:3:"));
  EXPECT_THAT(wrong.errors, HasSubstr("bridges.robots.domain"));
}

}  // namespace
}  // namespace rubicon::daemon
