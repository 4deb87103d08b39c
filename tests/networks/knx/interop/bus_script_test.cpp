#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <string>

#include "support/knxd.h"
#include "support/private_network.h"

namespace rubicon::networks::knx::line {
namespace {

using ::testing::HasSubstr;

const std::string kScript = RUBICON_SOURCE_DIR "/examples/knx-bus.sh";

/// knxd joins the group of KNX even for a tunnel on loopback, and ends where nothing leads there.
TEST(BusOfTheDemo, SaysWhyItCannotBeThereWithoutARouteToTheGroup) {
  {
    const support::KnxNetwork tools;
    if (!tools.entered()) GTEST_SKIP() << tools.reason();
  }
  const support::PrivateNetwork without_routes;
  ASSERT_TRUE(without_routes.entered()) << without_routes.reason();
  const auto ended = support::run_to_end({"bash", kScript});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.errors, HasSubstr("no route to the multicast group 224.0.23.12"));
}

TEST(BusOfTheDemo, RunsUntilItIsEndedWhereThereIsARoute) {
  const support::KnxNetwork network;
  if (!network.entered()) GTEST_SKIP() << network.reason();
  support::Process bus({"bash", kScript});
  const auto listener = support::run_to_end({"bash", "-c", "until grep -q ':3567 ' /proc/net/udp; do sleep 0.1; done"});
  EXPECT_EQ(listener.code, 0) << "port 13671 is 3567 in hex";
  bus.signal(SIGTERM);
  EXPECT_EQ(bus.exit_code(), 0);
}

/// What a program that ended leaves behind becomes our child.
class LeftBehind {
 public:
  LeftBehind() { EXPECT_EQ(::prctl(PR_SET_CHILD_SUBREAPER, 1), 0); }
  ~LeftBehind() { ::prctl(PR_SET_CHILD_SUBREAPER, 0); }
  LeftBehind(const LeftBehind&) = delete;
  LeftBehind& operator=(const LeftBehind&) = delete;

  /// False: something still runs.
  static bool nothing() {
    pid_t ended = 0;
    while ((ended = ::waitpid(-1, nullptr, WNOHANG)) > 0) continue;
    return ended < 0 && errno == ECHILD;
  }
};

TEST(BusOfTheDemo, LeavesNoProcessAndNoFolderBehind) {
  const support::KnxNetwork network;
  if (!network.entered()) GTEST_SKIP() << network.reason();
  const auto folder = std::filesystem::temp_directory_path() / ("rubicon_bus_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const LeftBehind left;
  ASSERT_TRUE(left.nothing());
  {
    support::Process bus({"env", "TMPDIR=" + folder.string(), "bash", kScript});
    // The thermometer says something: lamp and listener are there too.
    const auto listen = "cd " + folder.string() +
                        "; until [ -S */bus.sock ]; do sleep 0.1; done\n"
                        "exec {heard}< <(exec knxtool groupsocketlisten local:$PWD/$(echo */bus.sock))\n"
                        "grep -qm1 'to 1/2/7' <&$heard; found=$?; kill $!; wait $!; exit $found";
    ASSERT_EQ(support::run_to_end({"timeout", "60", "bash", "-c", listen}).code, 0);
    bus.signal(SIGTERM);
    EXPECT_EQ(bus.exit_code(), 0);
  }
  EXPECT_TRUE(left.nothing());
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
