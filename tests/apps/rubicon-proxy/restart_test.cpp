#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/conversation.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using nlohmann::json;
using testing::HasSubstr;

/// The real program with a state file; ended, killed and told to read its file again.
class DaemonWithMemory : public testing::Test {
 protected:
  DaemonWithMemory() {
    directory_ = std::filesystem::path(testing::TempDir()) /
                 ("rubicon_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
    configure("ask", "20");
  }
  ~DaemonWithMemory() override { std::filesystem::remove_all(directory_); }

  void configure(const std::string& new_devices, const std::string& value) {
    std::ofstream(file(), std::ios::binary)
        << "island: {id: 6541, name: test}\n"
           "state: {file: home.state, save-every: 100ms}\n"
           "discovery: {new-devices: "
        << new_devices
        << "}\n"
           "networks:\n"
           "  dummy-1: {type: dummy, simulate: {hall: {sensors: {temperature-1: {wave: constant, value: "
        << value
        << "}}}, attic: {sensors: {temperature-1: {wave: constant, value: 5}}}}}\n"
           "tuples: {engine: memory}\n";
  }
  std::string file() const { return (directory_ / "home.yaml").string(); }

  static json answer(Process& shell, const std::string& command) { return support::ask(shell, command); }
  /// Repeats a question until its answer says so much; false after a minute.
  static bool until(Process& shell, const std::string& command, const std::string& member, const json& expected) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < deadline) {
      const auto line = answer(shell, command);
      if (line.is_null()) return false;
      if (line.contains(member) && line[member] == expected) return true;
    }
    return false;
  }

  std::filesystem::path directory_;
};

TEST_F(DaemonWithMemory, ADecisionSurvivesAKillInTheNextInstant) {
  {
    Process daemon({kDaemon, "run", file(), "--shell"});
    ASSERT_TRUE(until(daemon, "inbox", "count", 2));
    ASSERT_EQ(answer(daemon, "approve dummy-1.hall")["ok"], true);
    ASSERT_EQ(answer(daemon, "ignore dummy-1.attic")["ok"], true);
    ASSERT_TRUE(until(daemon, "inbox", "ignored", 1));
    daemon.signal(SIGKILL);
    EXPECT_EQ(daemon.exit_code(), 128 + SIGKILL);
  }
  Process daemon({kDaemon, "run", file(), "--shell"});
  ASSERT_TRUE(until(daemon, "inbox", "ignored", 1));
  EXPECT_EQ(answer(daemon, "inbox")["count"], 0);
  EXPECT_TRUE(until(daemon, "devices", "count", 1));
}

TEST_F(DaemonWithMemory, TheLastValueIsThereAfterAKill) {
  configure("auto", "20");
  const std::string key = "proxy.dummy-1.hall.sensor.temperature-1.value";
  {
    Process daemon({kDaemon, "run", file(), "--shell"});
    ASSERT_TRUE(until(daemon, "devices", "count", 2));
    answer(daemon, "subscribe " + key);
    ASSERT_TRUE(daemon.line_with("\"value\":\"20\""));
    ASSERT_TRUE(until_saved((directory_ / "home.state").string(), R"("value":"20")")) << daemon.errors();
    daemon.signal(SIGKILL);
    daemon.exit_code();
  }
  Process daemon({kDaemon, "run", file(), "--shell"});
  ASSERT_TRUE(until(daemon, "get " + key, "value", "20"));
  const auto status = answer(daemon, "get proxy.dummy-1.hall.sensor.temperature-1.status");
  EXPECT_THAT(status["value"].get<std::string>(), HasSubstr("stored"));
}

TEST_F(DaemonWithMemory, SighupTakesTheNewFileAndARefusedOneChangesNothing) {
  configure("auto", "20");
  const std::string key = "proxy.dummy-1.hall.sensor.temperature-1.value";
  Process daemon({kDaemon, "run", file(), "--shell"});
  ASSERT_TRUE(until(daemon, "devices", "count", 2));
  answer(daemon, "subscribe " + key);
  ASSERT_TRUE(daemon.line_with("\"value\":\"20\""));
  configure("auto", "cold");
  const auto refused = answer(daemon, "reload");
  EXPECT_EQ(refused["ok"], false);
  EXPECT_THAT(refused["error"]["text"].get<std::string>(), HasSubstr("home.yaml:5:"));
  ASSERT_TRUE(daemon.line_with("\"value\":\"20\"")) << "runs on as before";
  configure("auto", "30");
  daemon.signal(SIGHUP);
  ASSERT_TRUE(daemon.line_with("\"value\":\"30\""));
  EXPECT_THAT(daemon.errors(), HasSubstr("reloaded"));
}

TEST_F(DaemonWithMemory, ACommandOfTheSettingsReloadsAndShowsTheOutcome) {
  configure("auto", "20");
  Process daemon({kDaemon, "run", file(), "--shell"});
  ASSERT_TRUE(until(daemon, "devices", "count", 2));
  answer(daemon, "subscribe proxy.settings.status");
  answer(daemon, "subscribe proxy.dummy-1.hall.sensor.temperature-1.value");
  configure("auto", "cold");
  EXPECT_EQ(answer(daemon, "set proxy.settings.command try")["ok"], true);
  const auto refused = daemon.line_with("\\\"state\\\":\\\"refused\\\"");
  ASSERT_TRUE(refused);
  EXPECT_THAT(*refused, HasSubstr("\\\"line\\\":5"));
  configure("auto", "30");
  EXPECT_EQ(answer(daemon, "set proxy.settings.command reload")["ok"], true);
  ASSERT_TRUE(daemon.line_with("\"value\":\"30\""));
  EXPECT_THAT(answer(daemon, "get proxy.settings.value")["value"].get<std::string>(), HasSubstr("value: 30"));
}

TEST_F(DaemonWithMemory, CheckDiffComparesWithTheLastGoodFile) {
  {
    Process daemon({kDaemon, "run", file(), "--shell"});
    ASSERT_TRUE(until(daemon, "inbox", "count", 2));
  }
  EXPECT_THAT(run_to_end({kDaemon, "check", file(), "--diff"}).output, HasSubstr("nothing would change"));
  configure("auto", "30");
  const auto changed = run_to_end({kDaemon, "check", file(), "--diff"});
  EXPECT_EQ(changed.code, 0);
  EXPECT_THAT(changed.output, HasSubstr("simulate.hall.sensors.temperature-1.value"));
  EXPECT_THAT(changed.output, HasSubstr("discovery rules change"));
  const auto against = run_to_end({kDaemon, "check", file(), "--diff", file()});
  EXPECT_THAT(against.output, HasSubstr("nothing would change"));
}

TEST_F(DaemonWithMemory, ADamagedStateFileIsSetAsideAndAForeignOneIsRefused) {
  std::ofstream(directory_ / "home.state", std::ios::binary) << "SQLite format 3" << '\0' << std::string(8192, 'x');
  {
    Process daemon({kDaemon, "run", file(), "--shell"});
    ASSERT_TRUE(until(daemon, "inbox", "count", 2));
    EXPECT_THAT(daemon.errors(), HasSubstr("home.state.damaged-"));
    daemon.write("quit\n");
    EXPECT_EQ(daemon.exit_code(), 0);
  }
  const auto foreign = run_to_end({kDaemon, "run", file(), "--shell", "--set", "island.id=7"});
  EXPECT_EQ(foreign.code, 2);
  EXPECT_THAT(foreign.errors, HasSubstr("of island 6541"));
}

TEST_F(DaemonWithMemory, AFileOfAnotherKindIsNeverMovedAway) {
  const auto before = std::filesystem::file_size(file());
  const auto refused = run_to_end({kDaemon, "run", file(), "--shell", "--set", "state.file=home.yaml"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("home.yaml"));
  EXPECT_EQ(std::filesystem::file_size(file()), before);
}

TEST_F(DaemonWithMemory, TwoDaemonsDoNotShareOneMemory) {
  Process first({kDaemon, "run", file(), "--shell"});
  ASSERT_TRUE(until(first, "inbox", "count", 2));
  const auto second = run_to_end({kDaemon, "run", file(), "--shell"});
  EXPECT_EQ(second.code, 2);
  EXPECT_THAT(second.errors, HasSubstr("home.state"));
}

}  // namespace
}  // namespace rubicon::daemon
