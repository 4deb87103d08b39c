#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "support/conversation.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

constexpr const char* kValue = "1:proxy.dummy-1.hall.sensor.temperature-1.value";

/// Daemons in processes of their own that reach each other by their folder, by DDS on loopback, or in a PEIS
/// network there.
class TwoIslands : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    directory_ = std::filesystem::path(testing::TempDir()) / ("rubicon_islands" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string island(int id, const std::string& more = "") const {
    const auto file = (directory_ / (std::to_string(id) + ".yaml")).string();
    std::ofstream(file, std::ios::binary)
        << "island: {id: " << id << ", name: island}\ntuples: {"
        << (is_on("host") ? "" : std::string("host: no, engine: ") + GetParam() + ", ") << "lease: 1s}\n"
        << "networks:\n  dummy-1: {type: dummy" << more
        << ", simulate: {hall: {sensors: {temperature-1: {wave: sine, "
           "low: 10, high: "
           "30, period: 5s}}, actuators: {switch-1: {}}}}}\n";
    return file;
  }
  static bool is_on(std::string_view engine) { return GetParam() == engine; }
  template <class Holds>
  static testing::AssertionResult until(Process& shell, const std::string& command, Holds holds,
                                        Clock::duration patience = 60s) {
    return support::until(shell, command, patience, holds);
  }
  static std::uint64_t sequence(Process& shell) {
    return ask(shell, std::string("get ") + (kValue + 2)).value("sequence", std::uint64_t{0});
  }

  PrivateNetwork alone_;
  std::filesystem::path directory_;
};

INSTANTIATE_TEST_SUITE_P(On, TwoIslands, testing::Values("host", "dds", "peis"),
                         [](const auto& of) { return of.param; });

TEST_P(TwoIslands, OneReadsAndCommandsTheOther) {
  Process first({kDaemon, "run", island(1), "--shell", "--log-level", "error"});
  Process second({kDaemon, "run", island(2), "--shell", "--log-level", "error"});
  ASSERT_TRUE(ask(second, std::string("subscribe ") + kValue + " min=50ms").value("ok", false));
  EXPECT_TRUE(until(second, std::string("get ") + kValue,
                    [](const json& tuple) { return tuple.value("ok", false) && !tuple.value("value", "").empty(); }));
  EXPECT_TRUE(until(second, "set 1:proxy.dummy-1.hall.actuator.switch-1.command on",
                    [](const json& answer) { return answer.value("verdict", "") == "applied"; }));
  EXPECT_TRUE(until(first, "get proxy.dummy-1.hall.actuator.switch-1.value",
                    [](const json& tuple) { return tuple.value("value", "") == "on"; }));
  EXPECT_EQ(ask(second, "set 77:proxy.x.command on").value("verdict", ""), "no-such-owner");
}

TEST_P(TwoIslands, SamplingStopsForAKilledSubscriber) {
  Process first({kDaemon, "run", island(1), "--shell", "--log-level", "error"});
  {
    Process second({kDaemon, "run", island(2), "--shell", "--log-level", "error"});
    ASSERT_TRUE(ask(second, std::string("subscribe ") + kValue + " min=50ms").value("ok", false));
    EXPECT_TRUE(until(first, std::string("get ") + (kValue + 2),
                      [](const json& tuple) { return tuple.value("sequence", 0) > 10; }));
    second.signal(SIGKILL);
  }
  // After the lease of a second nothing moves for six periods; a busy machine may see the loss later.
  bool at_rest = false;
  for (const auto end = Clock::now() + 60s; !at_rest && Clock::now() < end;) {
    const auto before = sequence(first);
    std::this_thread::sleep_for(300ms);
    at_rest = sequence(first) == before;
  }
  EXPECT_TRUE(at_rest);
}

TEST_P(TwoIslands, OfTwoWithOneIdTheLaterOneEnds) {
  Process first({kDaemon, "run", island(1), "--shell", "--log-level", "error"});
  ASSERT_TRUE(ask(first, "get proxy.networks").value("ok", false));
  Process second({kDaemon, "run", island(1), "--shell"});
  EXPECT_EQ(second.exit_code(), 1);
  const auto* who = is_on("host")  ? "component 1 runs already: rubicon-proxy, pid [0-9]+ of .* since 20[-0-9: ]+"
                    : is_on("dds") ? "component id 1 is in use by another process, pid [0-9]+ of .* on .*"
                                   : "component id 1 is in use by another process";
  EXPECT_THAT(second.errors(),
              testing::ContainsRegex(std::string(who) + ": stop that one, or give this island another id .`island.id`, "
                                                        "or --set island.id=2."));
  EXPECT_THAT(second.errors(), testing::Not(HasSubstr("is up"))) << "it opens no line and publishes nothing";
  EXPECT_TRUE(ask(first, "get proxy.networks").value("ok", false));
}

TEST_P(TwoIslands, OneStartsAtOnceWhileOthersStillSeeAnOldOneThatSaysNothingMore) {
  if (!is_on("dds")) GTEST_SKIP() << "the kernel knows that the old one lives";
  Process other({kDaemon, "run", island(2), "--shell", "--log-level", "error"});
  ASSERT_TRUE(ask(other, std::string("subscribe ") + kValue + " min=50ms").value("ok", false));
  const auto is_there = [](const json& tuple) { return tuple.value("ok", false) && !tuple.value("value", "").empty(); };
  Process first({kDaemon, "run", island(1), "--shell", "--log-level", "error"});
  ASSERT_TRUE(until(other, std::string("get ") + kValue, is_there));
  first.signal(SIGSTOP);  // of a killed one the system would close the ports
  const auto stopped_at = ask(other, std::string("get ") + kValue).value("write", 0.0);
  Process again({kDaemon, "run", island(1), "--shell"});
  EXPECT_TRUE(until(again, "get proxy.networks", is_there)) << again.errors();
  EXPECT_TRUE(until(other, std::string("get ") + kValue, [&](const json& tuple) {
    return tuple.value("write", 0.0) > stopped_at + 3;  // three leases
  })) << again.errors();
  again.write("quit\n");
  EXPECT_EQ(again.exit_code(), 0) << again.errors();
}

TEST_P(TwoIslands, ADeviceOfOneDomainIsListedByOneOfThem) {
  const auto roaming = ", roaming: lab";
  Process first({kDaemon, "run", island(1, roaming), "--shell", "--log-level", "error"});
  const auto listed = [](const json& tuple) { return tuple.value("ok", false); };
  const auto gone = [](const json& tuple) { return !tuple.value("ok", true); };
  const auto status = "get proxy.dummy-1.hall.status";
  ASSERT_TRUE(until(first, status, listed));
  {
    Process second({kDaemon, "run", island(2, roaming), "--shell", "--log-level", "error"});
    EXPECT_TRUE(until(second, status, listed));
    EXPECT_TRUE(until(first, status, gone)) << "its newest join was at the second one";
    ASSERT_TRUE(ask(first, "subscribe 2:ROAMING.lab.hall").value("ok", false));
    EXPECT_TRUE(until(first, "get 2:ROAMING.lab.hall", listed));
    EXPECT_TRUE(until(second, status, listed));
    second.write("quit\n");
    EXPECT_EQ(second.exit_code(), 0);
  }
  // Once it hears the device's next sign of life.
  EXPECT_TRUE(until(first, status, listed, 60s)) << "it still hears the device that the other one let go";
}

TEST_P(TwoIslands, AnIslandThatStartsAgainIsFollowed) {
  Process second({kDaemon, "run", island(2), "--shell", "--log-level", "error"});
  ASSERT_TRUE(ask(second, std::string("subscribe ") + kValue + " min=50ms").value("ok", false));
  for (int start = 0; start < 3; ++start) {
    Process first({kDaemon, "run", island(1), "--shell", "--log-level", "error"});
    EXPECT_TRUE(until(first, std::string("get ") + (kValue + 2),
                      [](const json& tuple) { return tuple.value("sequence", 0) > 3; }));
    const auto now = sequence(first);
    EXPECT_TRUE(until(second, std::string("get ") + kValue,
                      [&](const json& tuple) { return tuple.value("sequence", std::uint64_t{0}) >= now; }));
    first.signal(SIGKILL);
  }
}

}  // namespace
}  // namespace rubicon::daemon
