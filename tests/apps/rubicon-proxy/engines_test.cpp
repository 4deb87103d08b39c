#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/conversation.h"
#include "support/mosquitto.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;

/// Daemons in processes of their own, on DDS, PEIS or both, on loopback in a network of their own.
class IslandsOnEngines : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    directory_ = std::filesystem::path(testing::TempDir()) /
                 ("rubicon_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  /// An island with a lamp, which a sensor sees.
  std::unique_ptr<Process> island(int id, const std::string& tuples) const {
    const auto file = (directory_ / (std::to_string(id) + ".yaml")).string();
    std::ofstream(file, std::ios::binary)
        << "island: {id: " << id << ", name: island}\ntuples: {" << tuples << ", lease: 1s}\n"
        << "networks:\n  dummy-1: {type: dummy, simulate: {hall: {sensors: {temperature-1: {wave: sine, low: 10, "
           "high: 30, period: 5s}}, actuators: {switch-1: {}}}}}\n";
    return std::make_unique<Process>(
        std::vector<std::string>{kDaemon, "run", file, "--shell", "--log-level", "warning"});
  }
  /// What `reader` has of island `id` follows, and its commands arrive.
  static void expect_reads_and_commands(Process& reader, int id, Process& owner) {
    const auto device = std::to_string(id) + ":proxy.dummy-1.hall.";
    const auto sensor = device + "sensor.temperature-1.value", lamp = device + "actuator.switch-1.value";
    ASSERT_TRUE(ask(reader, "subscribe " + sensor + " min=100ms").value("ok", false));
    ASSERT_TRUE(ask(reader, "subscribe " + lamp).value("ok", false));
    EXPECT_TRUE(until(reader, "get " + sensor, 60s, [](const json& tuple) {
      return tuple.value("sequence", 0) > 5 && !tuple.value("value", "").empty();
    })) << "its demand reaches the owner, which measures";
    EXPECT_TRUE(until(reader, "set " + device + "actuator.switch-1.command on", 60s,
                      [](const json& answer) { return answer.value("verdict", "") == "applied"; }));
    EXPECT_TRUE(until(owner, "get proxy.dummy-1.hall.actuator.switch-1.value", 60s,
                      [](const json& tuple) { return tuple.value("value", "") == "on"; }));
    EXPECT_TRUE(until(reader, "get " + lamp, 60s, [](const json& tuple) { return tuple.value("value", "") == "on"; }));
    ASSERT_TRUE(ask(owner, "set proxy.dummy-1.hall.actuator.switch-1.command off").value("ok", false));
    EXPECT_TRUE(until(reader, "get " + lamp, 60s, [](const json& tuple) { return tuple.value("value", "") == "off"; }));
  }
  /// The islands that `reader` shows are these, each once.
  static testing::AssertionResult shows(Process& reader, const std::vector<int>& islands) {
    return until(reader, "get proxy.islands", 60s, [&](const json& tuple) {
      const auto list = json::parse(tuple.value("value", ""), nullptr, false);
      std::vector<int> ids;
      for (const auto& one : list) ids.push_back(one.value("id", 0));
      std::sort(ids.begin(), ids.end());
      return ids == islands;
    });
  }
  static void expect_quiet(Process& daemon) {
    daemon.write("quit\n");
    EXPECT_EQ(daemon.exit_code(), 0);
    EXPECT_EQ(daemon.errors(), "");
  }

  PrivateNetwork alone_;
  std::filesystem::path directory_;
};

TEST_F(IslandsOnEngines, TwoOnBothShowEachOtherOnceAndBothToOneOnPeis) {
  const auto first = island(1, "host: no, engine: [dds, peis]"), second = island(2, "host: no, engine: [dds, peis]"),
             third = island(3, "host: no, engine: peis");
  EXPECT_TRUE(shows(*first, {2, 3}));
  EXPECT_TRUE(shows(*second, {1, 3}));
  EXPECT_TRUE(shows(*third, {1, 2}));
  expect_reads_and_commands(*second, 1, *first);
  expect_reads_and_commands(*first, 2, *second);
  expect_reads_and_commands(*third, 1, *first);
  for (const auto* daemon : {&third, &second, &first}) expect_quiet(**daemon);
}

/// Each pair of wires; on a host its folder counts.
TEST_F(IslandsOnEngines, OfOneHostMeetInItsFolderWhateverElseTheyHave) {
  const auto first = island(1, "engine: [dds, peis]"), second = island(2, "engine: dds"),
             third = island(3, "engine: peis"), fourth = island(4, "engine: host");
  EXPECT_TRUE(shows(*first, {2, 3, 4}));
  EXPECT_TRUE(shows(*second, {1, 3, 4}));
  EXPECT_TRUE(shows(*third, {1, 2, 4}));
  EXPECT_TRUE(shows(*fourth, {1, 2, 3}));
  expect_reads_and_commands(*fourth, 1, *first);
  expect_reads_and_commands(*first, 2, *second);
  expect_reads_and_commands(*second, 3, *third);
  expect_reads_and_commands(*third, 4, *fourth);
  for (const auto* daemon : {&fourth, &third, &second, &first}) expect_quiet(**daemon);
}

TEST_F(IslandsOnEngines, OneCarriesBetweenOneOnDdsAndOneOnPeis) {
  const auto native = island(1, "host: no, engine: dds"), kernel = island(3, "host: no, engine: peis");
  auto carrier = island(2, "host: no, engine: [dds, peis], peis: {carry: [1, 3]}");
  EXPECT_TRUE(shows(*native, {2, 3}));
  EXPECT_TRUE(shows(*kernel, {1, 2}));
  EXPECT_TRUE(shows(*carrier, {1, 3})) << "each once: it does not see its own stand-ins";
  expect_reads_and_commands(*kernel, 1, *native);
  expect_reads_and_commands(*native, 3, *kernel);
  carrier->signal(SIGKILL);
  EXPECT_TRUE(shows(*native, {}));
  EXPECT_TRUE(shows(*kernel, {})) << "stand-ins end with their carrier";
  carrier = island(2, "host: no, engine: [dds, peis], peis: {carry: [1, 3]}");
  EXPECT_TRUE(shows(*kernel, {1, 2}));
  expect_reads_and_commands(*kernel, 1, *native);
  expect_quiet(*carrier);
  EXPECT_TRUE(shows(*kernel, {}));
  for (const auto* daemon : {&kernel, &native}) expect_quiet(**daemon);
}

/// A site of DDS, and another one that sees the broker only.
TEST_F(IslandsOnEngines, WhatIsOnDdsIsSeenOverTheBrokerAsLongAsOneCarries) {
  const Mosquitto broker;
  const std::string at_broker = "mqtt: {broker: 127.0.0.1, trust_broker: yes, watch: all}";
  const auto carries = "host: no, engine: [dds, mqtt], carry: [{what: 1, from: dds, to: mqtt}], " + at_broker;
  const auto native = island(1, "host: no, engine: dds"), distant = island(3, "host: no, engine: mqtt, " + at_broker);
  auto first = island(2, carries);
  const auto second = island(4, carries);
  EXPECT_TRUE(shows(*distant, {1, 2, 4}));
  EXPECT_TRUE(shows(*native, {2, 4})) << "nothing is carried there but who looks or commands";
  expect_reads_and_commands(*distant, 1, *native);
  first->signal(SIGKILL);
  EXPECT_TRUE(shows(*distant, {1, 4}));
  expect_reads_and_commands(*distant, 1, *native);
  first = island(2, carries);
  EXPECT_TRUE(shows(*distant, {1, 2, 4}));
  expect_reads_and_commands(*distant, 1, *native);
}

TEST_F(IslandsOnEngines, ACheckExplainsWhatIsCarried) {
  const auto file = (directory_ / "carry.yaml").string();
  std::ofstream(file, std::ios::binary)
      << "island: {id: 2}\ntuples: {engine: [dds, peis], peis: {carry: [4711, kitchen.**]}}\nnetworks: {}\n";
  const auto outcome = run_to_end({kDaemon, "check", file});
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_THAT(outcome.output,
              HasSubstr("carries component 4711, kitchen.** of every component from dds or peis to dds or peis"));
}

}  // namespace
}  // namespace rubicon::daemon
