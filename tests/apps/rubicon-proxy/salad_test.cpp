#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

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

const std::string kTelevision = "proxy.salad.28.actuator.status-tv_state";

/// How many devices the next `devices` lists, and how many of them have this status.
std::pair<int, int> devices(Process& shell, const std::string& status) {
  shell.write("devices\n");
  int count = 0, of_status = 0;
  for (auto line = parsed(shell.line()); line.contains("device"); line = parsed(shell.line())) {
    ++count;
    of_status += line["status"] == status;
  }
  return {count, of_status};
}

/// Asks until the value of a tuple is this; false after a minute.
bool becomes(Process& shell, const std::string& key, const std::string& value) {
  for (const auto end = Clock::now() + 60s; Clock::now() < end;) {
    const auto line = support::ask(shell, "get " + key);
    if (line.is_object() && line["value"].is_string() &&
        line["value"].get<std::string>().find(value) != std::string::npos)
      return true;
  }
  return false;
}

TEST(SaladFlat, EveryStartShowsAll55Devices) {
  for (int i = 0; i < 20; ++i) {
    Process shell(
        {kDaemon, "run", kFlat, "--set", "tuples.engine=memory", "--shell", "--set", "networks.salad.rubicon_port=0"});
    EXPECT_EQ(devices(shell, "unknown"), std::pair(55, 55)) << "at the first question of start " << i << shell.errors();
    shell.close_input();
    EXPECT_EQ(shell.exit_code(), 0);
  }
}

TEST(SaladFlat, LivesWithTheSimulatorAndObeysCommands) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  Process shell({kDaemon, "run", kFlat, "--set", "tuples.engine=memory", "--shell", "--set",
                 "networks.salad.start-again-after=200ms"});
  EXPECT_EQ(devices(shell, "unknown").first, 55) << "before SALAD is there";
  EXPECT_TRUE(becomes(shell, "proxy.salad.status", "SALAD cannot be reached"));
  Process salad({kSimulator, kFlat, "--period", "50ms", "--misbehave", "all"});
  EXPECT_TRUE(salad.line_with("55 devices, listening on 127.0.0.1 port 9000")) << salad.errors();
  EXPECT_TRUE(becomes(shell, kTelevision + ".value", "0")) << "the updates were asked for again";
  EXPECT_EQ(devices(shell, "reachable"), std::pair(55, 55));
  shell.write("set " + kTelevision + ".command 10\n");
  EXPECT_EQ(parsed(shell.line())["verdict"], "applied");
  EXPECT_TRUE(becomes(shell, kTelevision + ".value", "10"));
  EXPECT_TRUE(becomes(shell, kTelevision + ".status", "confirmed"));
  shell.write("set proxy.salad.66.actuator.relay-knx_blind_down.command on\n");
  EXPECT_EQ(parsed(shell.line())["verdict"], "applied");
  EXPECT_TRUE(becomes(shell, "proxy.salad.66.actuator.relay-knx_blind_down.value", "on"));
  salad.signal(SIGTERM);
  EXPECT_EQ(salad.exit_code(), 0);
  EXPECT_TRUE(becomes(shell, "proxy.salad.status", "SALAD cannot be reached"));
  shell.write("quit\n");
  EXPECT_EQ(shell.exit_code(), 0);
}

TEST(SaladFlat, TheEndOfTheIslandStopsTheUpdates) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  Process salad({kSimulator, RUBICON_SOURCE_DIR "/examples/salad.properties", "--script",
                 RUBICON_SOURCE_DIR "/examples/salad.script", "--period", "50ms"});
  ASSERT_TRUE(salad.line_with("listening")) << salad.errors();
  Process shell({kDaemon, "run", kFlat, "--set", "tuples.engine=memory", "--shell"});
  EXPECT_TRUE(becomes(shell, "proxy.salad.7.sensor.switch-fridge.value", "o"));
  shell.signal(SIGTERM);
  EXPECT_EQ(shell.exit_code(), 0);
  const auto end = std::chrono::steady_clock::now() + 60s;
  while (salad.errors().find("updates stop") == std::string::npos && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(10ms);  // the message may still be on its way
  salad.signal(SIGTERM);
  EXPECT_EQ(salad.exit_code(), 0);
  const auto said = salad.errors();
  EXPECT_LT(said.find("updates start"), said.find("updates stop"));
  EXPECT_THAT(said, HasSubstr("updates stop"));
}

TEST(SaladFlat, ATakenPortIsSaidAndTheDevicesAreThere) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  Process squatter({kSimulator, kFlat, "--listen", "9100", "--proxy", "localhost:1"});
  ASSERT_TRUE(squatter.line());
  Process shell({kDaemon, "run", kFlat, "--set", "tuples.engine=memory", "--shell"});
  EXPECT_TRUE(becomes(shell, "proxy.salad.status", "Address already in use"));
  EXPECT_EQ(devices(shell, "unknown").first, 55);
  squatter.signal(SIGTERM);
  EXPECT_TRUE(becomes(shell, "proxy.salad.status", "SALAD cannot be reached"));
  EXPECT_TRUE(becomes(shell, "proxy.salad.property.line.value", "down"));
}

TEST(SaladSimulator, SaysWhatIsWrongWithItsArguments) {
  const std::string home = RUBICON_SOURCE_DIR "/examples/home.yaml";
  EXPECT_EQ(run_to_end({kSimulator, "--help"}).code, 0);
  EXPECT_EQ(run_to_end({kSimulator, "--version"}).code, 0);
  EXPECT_EQ(run_to_end({kSimulator}).code, 1);
  EXPECT_EQ(run_to_end({kSimulator, "/nowhere.properties"}).code, 2);
  EXPECT_EQ(run_to_end({kSimulator, home, "--network", "nothing"}).code, 2);
  EXPECT_EQ(run_to_end({kSimulator, kFlat, "--period", "soon"}).code, 2);
  EXPECT_EQ(run_to_end({kSimulator, kFlat, "--proxy", "host:0"}).code, 2);
  EXPECT_EQ(run_to_end({kSimulator, kFlat, "--misbehave", "politely"}).code, 2);
  const auto script = run_to_end({kSimulator, home, "--script", kFlat});
  EXPECT_EQ(script.code, 2);
  EXPECT_THAT(script.errors, HasSubstr("salad.yaml: line 3: "));
}

}  // namespace
}  // namespace rubicon::daemon
