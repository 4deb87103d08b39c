#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
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

const std::string kLight = "proxy.wsn-1.2.sensor.light-1";

/// The real daemon and simulated motes, in a network of their own.
class MotesDaemon : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("rubicon_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return path(name);
  }
  /// An island with one network, its options as in YAML.
  std::string island(const std::string& network, int id = 6543, const std::string& key = "wsn-1") const {
    return write("island.yaml", "island: {id: " + std::to_string(id) +
                                    ", name: motes}\ntuples: {engine: memory}\n"
                                    "state: {file: motes.state, save-every: 100ms}\nnetworks:\n  " +
                                    key + ": {" + network + "}\n");
  }
  static std::string over_tcp(const std::string& more = "") {
    return "type: wsn, board: EM1000, silence: 60s, source: 'network@127.0.0.1:19202'" + more;
  }
  std::vector<std::string> motes(std::vector<std::string> more = {}) const {
    std::vector<std::string> all{kMotes, "--motes", "3", "--wait", "--boot-spacing", "150ms"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::size_t events(const std::string& what) const {
    std::ifstream file(folder_ / "events");
    std::size_t count = 0;
    for (std::string line; std::getline(file, line);) count += line.find("\"" + what) != std::string::npos;
    return count;
  }

  static testing::AssertionResult there(Process& shell, const std::string& mote) {
    return until(shell, "get proxy.wsn-1." + mote + ".status", 60s, [](const json& answer) {
      return answer.contains("value") && answer["value"].get<std::string>().find("\"reachable\"") != std::string::npos;
    });
  }
  static testing::AssertionResult becomes(Process& shell, const std::string& key, const std::string& part) {
    return until(shell, "get " + key, 60s, [&](const json& answer) {
      return answer.contains("value") && answer["value"].get<std::string>().find(part) != std::string::npos;
    });
  }
  static std::uint64_t sequence(Process& shell, const std::string& key) {
    return ask(shell, "get " + key).value("sequence", std::uint64_t{0});
  }
  /// The first line of a file that calls the simulator, without what stands before the call.
  static std::string documented_line(const std::string& file, const std::string& before) {
    std::ifstream text(RUBICON_SOURCE_DIR "/" + file);
    for (std::string line; std::getline(text, line);) {
      if (line.starts_with(before + "motes-simulator ")) return line.substr(before.size());
    }
    return "";
  }
  /// So many more values of a tuple.
  static testing::AssertionResult flows(Process& shell, const std::string& key, std::uint64_t values) {
    const auto wanted = sequence(shell, key) + values;
    return until(shell, "get " + key, 60s,
                 [&](const json& answer) { return answer.value("sequence", std::uint64_t{0}) >= wanted; });
  }
  static void end(Process& shell) {
    shell.write("quit\n");
    EXPECT_EQ(shell.exit_code(), 0) << shell.errors();
  }

  PrivateNetwork alone_;
  std::filesystem::path folder_;
};

TEST_F(MotesDaemon, TheExampleIsGoodAndMeetsTheSimulator) {
  const std::string example = RUBICON_SOURCE_DIR "/examples/motes.yaml";
  const auto checked = run_to_end({kDaemon, "check", example});
  EXPECT_EQ(checked.code, 0) << checked.errors;
  const auto line = documented_line("examples/motes.yaml", "#   ");
  ASSERT_NE(line, "");
  EXPECT_EQ(documented_line("docs/motes-simulator.md", "    "), line);
  Process world({"sh", "-c", "cd " RUBICON_SOURCE_DIR " && exec " RUBICON_BINARY_DIR "/bin/" + line});
  ASSERT_TRUE(world.line_with("network@127.0.0.1:19202")) << world.errors();
  Process shell({kDaemon, "run", example, "--shell", "--set", "tuples.engine=memory"});
  for (const auto* mote : {"2", "3", "4", "5", "6", "7"}) EXPECT_TRUE(there(shell, mote)) << mote;
  EXPECT_EQ(ask(shell, "subscribe proxy.wsn-1.2.sensor.light-1.value min=200ms")["ok"], true);
  EXPECT_TRUE(flows(shell, "proxy.wsn-1.2.sensor.light-1.value", 2)) << "the released firmware sends it";
  EXPECT_EQ(ask(shell, "set proxy.wsn-1.3.actuator.led-1.command 1")["verdict"], "applied");
  EXPECT_TRUE(becomes(shell, "proxy.wsn-1.3.actuator.led-1.status", "\"timed-out\"")) << "which it ignores";
  end(shell);
}

TEST_F(MotesDaemon, SharesTheSinkWithAnotherProgramWhileItSamples) {
  Process world(motes({"--events", path("events")}));
  ASSERT_TRUE(world.line_with("network@127.0.0.1:19202")) << world.errors();
  Process shell({kDaemon, "run", island(over_tcp()), "--shell"});
  for (const auto* mote : {"2", "3", "4"}) ASSERT_TRUE(there(shell, mote)) << mote << shell.errors();
  EXPECT_EQ(ask(shell, "subscribe " + kLight + ".value min=200ms")["ok"], true);
  ASSERT_TRUE(flows(shell, kLight + ".value", 2));
  EXPECT_TRUE(becomes(shell, "proxy.wsn-1.property.share.value", "127.0.0.1:9002"));
  const auto client = run_to_end({"python3", RUBICON_SOURCE_DIR "/tests/apps/rubicon-proxy/sink_client.py", "127.0.0.1",
                                  "9002", "6543", "3", "2"});
  ASSERT_EQ(client.code, 0) << client.errors;
  const auto commands = client.output.substr(0, client.output.find('\n'));
  EXPECT_TRUE(flows(shell, kLight + ".value", 3)) << "the island samples as before";
  EXPECT_TRUE(becomes(shell, "proxy.wsn-1.3.sensor.light-1.status", "\"good\"")) << "and hears what others ask for";
  EXPECT_TRUE(becomes(shell, "proxy.wsn-1.property.share-packets-from-clients.value", commands));
  end(shell);
}

TEST_F(MotesDaemon, ItsMotesStopSamplingWhenItEnds) {
  Process world(motes({"--events", path("events")}));
  ASSERT_TRUE(world.line_with("network@127.0.0.1:19202")) << world.errors();
  Process shell({kDaemon, "run", island(over_tcp()), "--shell"});
  for (const auto* mote : {"2", "3", "4"}) ASSERT_TRUE(there(shell, mote)) << mote << shell.errors();
  EXPECT_EQ(ask(shell, "subscribe " + kLight + ".value min=200ms")["ok"], true);
  ASSERT_TRUE(flows(shell, kLight + ".value", 2));
  EXPECT_EQ(events("010000ffff"), 0U);
  shell.signal(SIGTERM);
  EXPECT_EQ(shell.exit_code(), 0) << shell.errors();
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  while (events("010000ffff") == 0 && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(10ms);  // the radio and the simulator's file are later than the end of the daemon
  EXPECT_GE(events("010000ffff"), 1U) << "mote 2 stops";
}

TEST_F(MotesDaemon, FindsItsMotesAgainAfterAKill) {
  Process world(motes({"--events", path("events")}));
  ASSERT_TRUE(world.line_with("network@127.0.0.1:19202")) << world.errors();
  const auto file = island(over_tcp());
  {
    Process shell({kDaemon, "run", file, "--shell"});
    for (const auto* mote : {"2", "3", "4"}) ASSERT_TRUE(there(shell, mote)) << mote << shell.errors();
    EXPECT_EQ(ask(shell, "subscribe " + kLight + ".value min=200ms")["ok"], true);
    ASSERT_TRUE(flows(shell, kLight + ".value", 3));
    for (const auto* mote : {"2", "3", "4"})
      ASSERT_TRUE(until_saved(path("motes.state"), "{\"address\":\"" + std::string(mote) + "\"")) << mote;
    shell.signal(SIGKILL);
    EXPECT_EQ(shell.exit_code(), 128 + SIGKILL);
  }
  Process shell({kDaemon, "run", file, "--shell"});
  for (const auto* mote : {"2", "3", "4"}) EXPECT_TRUE(there(shell, mote)) << mote << shell.errors();
  EXPECT_TRUE(becomes(shell, "proxy.wsn-1.4.description", "humidity-1")) << "which it never sent";
  EXPECT_EQ(events("boot"), 3U);
  EXPECT_EQ(events("listed"), 3U);
  end(shell);
}

TEST_F(MotesDaemon, WorksOnAPseudoTerminal) {
  const auto line = path("sink");
  // Until the daemon is there, motes join a sink that nobody listens to.
  const std::vector<std::string> call{
      kMotes,
      "--motes",
      "2",
      "--pty",
      line,
      "--script",
      write("script", "at 2s reboot all over 500ms\nat 15s reboot all over 500ms\nat 40s reboot all over 500ms\n")};
  const auto file = island("type: wsn, board: EM1000, share: no, source: 'serial@" + line + ":telosb'", 11);
  auto world = std::make_unique<Process>(call);
  ASSERT_TRUE(world->line_with("serial@" + line)) << world->errors();
  Process shell({kDaemon, "run", file, "--shell"});
  for (const auto* mote : {"2", "3"}) ASSERT_TRUE(there(shell, mote)) << mote << shell.errors();
  EXPECT_EQ(ask(shell, "subscribe " + kLight + ".value min=200ms")["ok"], true);
  ASSERT_TRUE(flows(shell, kLight + ".value", 2));
  world.reset();  // pulled out
  EXPECT_TRUE(becomes(shell, "proxy.wsn-1.status", line)) << "what is missing";
  world = std::make_unique<Process>(call);
  ASSERT_TRUE(world->line_with("serial@" + line)) << world->errors();
  EXPECT_TRUE(becomes(shell, "proxy.wsn-1.property.line.value", "up"));
  EXPECT_TRUE(flows(shell, kLight + ".value", 2)) << "what is wanted is asked for again";
  end(shell);
}

TEST_F(MotesDaemon, WhatItRecordedIsPlayedAsALog) {
  std::string recorded;
  {
    Process world(motes());
    ASSERT_TRUE(world.line_with("network@127.0.0.1:19202")) << world.errors();
    Process shell({kDaemon, "run", island(over_tcp(", record: motes.log")), "--shell"});
    for (const auto* mote : {"2", "3", "4"}) ASSERT_TRUE(there(shell, mote)) << mote << shell.errors();
    EXPECT_EQ(ask(shell, "subscribe " + kLight + ".value min=200ms")["ok"], true);
    ASSERT_TRUE(flows(shell, kLight + ".value", 3));
    ask(shell, "unsubscribe " + kLight + ".value");
    ASSERT_TRUE(becomes(shell, "proxy.wsn-1.2.property.mask.value", "0"));
    recorded = ask(shell, "get " + kLight + ".value").value("value", "");
    end(shell);
  }
  ASSERT_NE(recorded, "");
  std::filesystem::remove(folder_ / "motes.state");
  Process shell({kDaemon, "run",
                 island("type: log, as: wsn-1, file: motes.log, board: EM1000, speed: max", 6543, "log-1"), "--shell"});
  for (const auto* mote : {"2", "3", "4"}) EXPECT_TRUE(there(shell, mote)) << mote << shell.errors();
  EXPECT_TRUE(becomes(shell, "proxy.wsn-1.4.description", "humidity-1"));
  EXPECT_TRUE(becomes(shell, kLight + ".value", recorded));
  end(shell);
}

}  // namespace
}  // namespace rubicon::daemon
