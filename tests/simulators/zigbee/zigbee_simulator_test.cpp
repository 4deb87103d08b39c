#include "apps/simulators/zigbee/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "apps/simulators/zigbee/replay.h"
#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"

namespace rubicon::zigbee_simulator {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A broker in memory, for a simulator or a replay.
class SimulatorOnBroker : public ::testing::Test {
 protected:
  SimulatorOnBroker() { memory.join(net); }
  static transport::MqttOptions at_broker() {
    transport::MqttOptions options;
    options.host = "localhost";
    return options;
  }
  void run(std::string_view script, SimulatorOptions options = {}) {
    auto parsed = parse_script(script);
    ASSERT_TRUE(parsed) << parsed.error().text;
    options.broker = at_broker();
    simulator = std::make_unique<Simulator>(options, std::move(*parsed), time, memory, Log(words, "simulator"));
    const auto opened = simulator->open();
    ASSERT_TRUE(opened) << opened.error().text;
    time.run_for(100ms);
  }
  std::vector<std::string> published(const std::string& topic) const {
    return broker.published("zigbee2mqtt/" + topic);
  }

  VirtualScheduler time;
  support::CollectingLog words;
  transport::MemoryNet net{time};
  transport::MemoryTransports memory;
  transport::MqttBroker broker{net, {"127.0.0.1", 1883}};
  std::unique_ptr<Simulator> simulator;
};

TEST_F(SimulatorOnBroker, PlaysItsScript) {
  run("device lamp hall/lamp\ndevice remote remote\n"
      "at 1s set hall/lamp state ON\nat 2s action remote toggle\nat 3s unknown hall/lamp brightness\n"
      "at 4s rename hall/lamp lamp\nat 5s fault lamp ignore\nat 6s leave remote\nat 7s say bridge/devices [{\n");
  time.run_for(1s);
  EXPECT_THAT(published("hall/lamp").back(), HasSubstr(R"("state":"ON")"));
  time.run_for(1s);
  EXPECT_THAT(published("remote").back(), HasSubstr(R"("action":"toggle")"));
  time.run_for(1s);
  EXPECT_THAT(published("hall/lamp").back(), HasSubstr(R"("brightness":null)"));
  time.run_for(1s);
  EXPECT_EQ(published("hall/lamp").back(), "");
  time.run_for(2s);
  EXPECT_TRUE(simulator->world().registry().find("lamp")->faults.ignores);
  EXPECT_THAT(published("bridge/event").back(), HasSubstr("device_leave"));
  time.run_for(1s);
  EXPECT_EQ(published("bridge/devices").back(), "[{");
}

TEST_F(SimulatorOnBroker, RepeatsAndNamesWhatIsGone) {
  run("device plug plug\nat 1s leave plug\nat 2s set plug state OFF\nat 3s join plug\nat 3s permit 60s\nat 10s "
      "repeat\n");
  time.run_for(15s);
  EXPECT_TRUE(words.contains("line 3: plug is not there any longer"));
  EXPECT_THAT(simulator->world().registry().devices(), SizeIs(2)) << "one joined in each round";
}

TEST_F(SimulatorOnBroker, ABridgeThatStopsComesBackWithCopiesOfOldStates) {
  run("device plug plug\nat 1s stop 10s\n");
  time.run_for(1s);
  EXPECT_EQ(broker.retained("zigbee2mqtt/bridge/state"), R"({"state":"offline"})");
  const auto states = published("plug");
  ASSERT_THAT(states, SizeIs(1));
  time.run_for(10s);
  EXPECT_EQ(broker.retained("zigbee2mqtt/bridge/state"), R"({"state":"online"})");
  EXPECT_THAT(published("plug"), ElementsAre(states[0], states[0]));
}

TEST_F(SimulatorOnBroker, ABurstJoinsWhileJoiningIsPermitted) {
  run("at 1s permit 254s\nat 2s burst 20\n");
  time.run_for(10s);
  EXPECT_THAT(simulator->world().registry().devices(), SizeIs(20));
}

TEST_F(SimulatorOnBroker, HasAsManyDevicesAsItsOptionsRequire) {
  SimulatorOptions options;
  options.devices = 30;
  options.generated = 10;
  options.world.every = 1s;
  run("", options);
  time.run_for(5s);
  EXPECT_THAT(simulator->world().registry().devices(), SizeIs(40));
  EXPECT_NE(simulator->world().registry().find("plug 2"), nullptr);
  EXPECT_GT(published("plug 2").size(), 4U);
}

TEST_F(SimulatorOnBroker, ABaseMayHaveSlashes) {
  SimulatorOptions options;
  options.world.base = "home/z2m";
  run("device plug plug\n", options);
  EXPECT_TRUE(broker.retained("home/z2m/bridge/state").has_value());
  broker.publish("home/z2m/plug/set", R"({"state":"OFF"})");
  time.run_for(1s);
  EXPECT_THAT(broker.published("home/z2m/plug").back(), HasSubstr(R"("state":"OFF")"));
}

TEST_F(SimulatorOnBroker, TwoDevicesOfOneNameAreRefused) {
  auto script = parse_script("device plug plug\ndevice lamp plug\n");
  SimulatorOptions options;
  options.broker = at_broker();
  Simulator twice(options, std::move(*script), time, memory, Log(words, "simulator"));
  const auto opened = twice.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().text, "friendly_name 'plug' is already in use");
}

constexpr std::string_view kTwoMessages =
    R"({"tst":"2026-11-21T00:00:00.500000Z+0000","topic":"zigbee2mqtt/bridge/state","payload":{"state":"online"}})"
    "\n"
    R"({"tst":"2026-11-21T00:00:01.000000Z+0000","topic":"zigbee2mqtt/a/set","payload":{"state":"ON"}})"
    "\n"
    R"({"tst":"2026-11-21T00:00:04.500000Z+0000","topic":"zigbee2mqtt/a","payload":""})"
    "\n";

TEST(ZigbeeTrace, HasTimesAndWhatTheBridgePublished) {
  const auto trace = read_trace(kTwoMessages);
  ASSERT_TRUE(trace) << trace.error().text;
  ASSERT_THAT(*trace, SizeIs(2)) << "commands are those of clients";
  EXPECT_EQ((*trace)[0].payload, R"({"state":"online"})");
  EXPECT_EQ((*trace)[1].at, Duration(4s));
  EXPECT_EQ((*trace)[1].payload, "");
}

TEST(ZigbeeTrace, SaysWhichLineIsWrong) {
  for (const auto* wrong :
       {"x", "{}", R"({"tst":"2026-11-21","topic":"a/b","payload":1})", R"({"tst":1,"topic":"a/b","payload":1})",
        R"({"tst":"2026-13-21T00:00:00Z","topic":"a/b","payload":1})",
        R"({"tst":"2026-11-21T00:00:00Z","topic":"a/b"})",
        R"({"tst":"2026-11-21T00:00:00Z","topic":"a","payload":1})"}) {
    const auto trace = read_trace("\n" + std::string(wrong));
    ASSERT_FALSE(trace) << wrong;
    EXPECT_THAT(trace.error().text, HasSubstr("line 2: "));
  }
}

class ReplayOnBroker : public SimulatorOnBroker {
 protected:
  void replay(double speed) {
    auto trace = read_trace(kTwoMessages);
    made = std::make_unique<Replay>(Replay::Options{"zigbee2mqtt", at_broker(), speed}, std::move(*trace), time, memory,
                                    Log(words, "replay"), [this](Result<void> end) { ends.push_back(std::move(end)); });
    ASSERT_TRUE(made->open());
  }

  std::unique_ptr<Replay> made;
  std::vector<Result<void>> ends;
};

TEST_F(ReplayOnBroker, KeepsTheTimesOfTheTrace) {
  replay(2);
  time.run_for(1900ms);
  EXPECT_TRUE(broker.retained("zigbee2mqtt/bridge/state").has_value());
  EXPECT_THAT(published("a"), IsEmpty());
  EXPECT_THAT(ends, IsEmpty());
  time.run_for(200ms);
  EXPECT_THAT(published("a"), ElementsAre(""));
  ASSERT_THAT(ends, SizeIs(1));
  EXPECT_TRUE(ends[0]);
}

TEST_F(ReplayOnBroker, OrPublishesAtOnce) {
  replay(0);
  time.run_for(10ms);
  EXPECT_THAT(published("a"), SizeIs(1));
}

TEST_F(ReplayOnBroker, EndsWithAnErrorIfTheBrokerIsLost) {
  replay(1);
  time.run_for(1s);
  broker.stop(true);
  time.run_for(1s);
  ASSERT_THAT(ends, SizeIs(1));
  EXPECT_FALSE(ends[0]);
}

TEST_F(ReplayOnBroker, OfTheRecordedTraceLeavesSixteenJoinsAndABridgeThatIsOffline) {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/zigbee/trace16-small.jsonl");
  if (!file) GTEST_SKIP() << "no ../shared/data/zigbee/trace16-small.jsonl beside the source tree";
  auto trace = read_trace(std::string{std::istreambuf_iterator<char>(file), {}});
  ASSERT_TRUE(trace) << trace.error().text;
  EXPECT_THAT(*trace, SizeIs(449)) << "452 without a request and two sets";
  made = std::make_unique<Replay>(Replay::Options{"zigbee2mqtt", at_broker(), 10}, std::move(*trace), time, memory,
                                  Log(words, "replay"), [this](Result<void> end) { ends.push_back(std::move(end)); });
  ASSERT_TRUE(made->open());
  time.run_for(3s);
  ASSERT_THAT(ends, SizeIs(1));
  EXPECT_EQ(broker.retained("zigbee2mqtt/bridge/state"), R"({"state":"offline"})");
  const auto events = published("bridge/event");
  const auto count = [&](const char* part) {
    return std::ranges::count_if(events, [&](auto& one) { return one.find(part) != one.npos; });
  };
  EXPECT_EQ(count("device_joined"), 16);
  EXPECT_EQ(count("device_leave"), 1);
}

}  // namespace
}  // namespace rubicon::zigbee_simulator
