#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

using testing::HasSubstr;

/// An island of one's own with a device that sleeps, one that does not, and a state file.
class OwnIsland : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    file_ = folder_.write("home.yaml", "island: {id: 6541, name: home}\nstate: {file: " + folder_.file("home.state") +
                                           "}\n"
                                           "networks:\n"
                                           "  dummy-1:\n"
                                           "    type: dummy\n"
                                           "    silence: 2s\n"
                                           "    simulate:\n"
                                           "      sleepy: {keepalive: 25s, actuators: {lock-1: {}}}\n"
                                           "  dummy-2:\n"
                                           "    type: dummy\n"
                                           "    simulate: {hall: {name: Front hall, actuators: {switch-1: {}}}}\n");
    begin();
  }
  void begin() {
    island_ = std::make_unique<Process>(std::vector<std::string>{kDaemon, "run", file_, "--shell", "--log-level",
                                                                 "info", "--set", "tuples.engine=dds"});
    island_->write("stats\n");
    std::ignore = island_->line_with("\"ok\"");
  }
  void end() {
    island_->signal(SIGTERM);
    EXPECT_EQ(island_->exit_code(), 0) << island_->errors();
  }
  static void wait_for_sleepy(const std::string& status) {
    Process watch({kProgram, "watch", "proxy.dummy-1.sleepy.status", "--passive", "--json"});
    ASSERT_TRUE(watch.line_with("\\\"" + status + "\\\"")) << watch.errors();
  }

  PrivateNetwork alone_;
  Folder folder_;
  std::string file_;
  std::unique_ptr<Process> island_;
};

TEST_F(OwnIsland, DoesNotCarryOutACommandAfterItsUserWasToldThatItExpired) {
  wait_for_sleepy("unreachable");
  const auto told = rubicon({"set", "sleepy.lock-1", "locked"});
  EXPECT_EQ(told.code, 6) << told.output;
  EXPECT_THAT(told.output, HasSubstr(" expired after"));
  EXPECT_THAT(told.output, HasSubstr("not sent within"));
  EXPECT_THAT(told.errors, HasSubstr("queued: the device is unreachable"));
  EXPECT_THAT(told.errors, HasSubstr(" s more)"));
  wait_for_sleepy("reachable");
  wait_for_sleepy("unreachable");  // it had time to do what was sent to it
  const auto point = lines_of(rubicon({"describe", "sleepy", "--json"})).at(0)["points"].at(0);
  EXPECT_NE(point["value"], "locked");
  EXPECT_EQ(point["status"]["command"]["state"], "expired");
  EXPECT_THAT(point["status"]["command"]["commander"].get<std::string>(), HasSubstr("rubicon set (pid "));
  end();
  EXPECT_THAT(island_->errors(), HasSubstr("lock-1 = 'locked' by rubicon set (pid "));
  EXPECT_THAT(island_->errors(), HasSubstr(": expired after 5"));
}

TEST_F(OwnIsland, KeepsTheNameAndAreaThatAUserGives) {
  const auto renamed = rubicon({"rename", "hall", "Hall lamp", "--area", "Entrance"});
  EXPECT_EQ(renamed.code, 0) << renamed.errors;
  EXPECT_EQ(renamed.output, "6541:proxy.dummy-2.hall is 'Hall lamp' in 'Entrance'\n");
  EXPECT_EQ(lines_of(rubicon({"devices", "--area", "Entr*", "--json"})).at(0)["name"], "Hall lamp");
  end();
  begin();
  EXPECT_THAT(rubicon({"describe", "Hall lamp"}).output, HasSubstr("Entrance"));
  EXPECT_EQ(rubicon({"rename", "hall", "", "--area", ""}).code, 0);
  EXPECT_THAT(rubicon({"describe", "hall"}).output, HasSubstr("Front hall"));
  EXPECT_EQ(rubicon({"devices", "--area", "*"}).code, 0);
  EXPECT_EQ(rubicon({"rename", "hall"}).code, 2);
  EXPECT_EQ(rubicon({"rename", "nowhere", "x"}).code, 8);
  EXPECT_EQ(rubicon({"rename", "hall", std::string(200, 'x')}).code, 3);
}

}  // namespace
}  // namespace rubicon::cli
