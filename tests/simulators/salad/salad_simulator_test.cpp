#include "apps/simulators/salad/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "networks/salad/salad_network.h"
#include "support/config_text.h"
#include "support/fake_host.h"

namespace rubicon::salad_simulator {
namespace {

using namespace std::chrono_literals;
using networks::salad::SaladDevice;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::string_view kTable = R"({"table": {"7": "FRIDGE,sensor.switch", "13": "BED,sensor.pressure",
  "28": "TV_STATE,sensor.status,LG", "46": "LIGHT,actuator.light,1/1/1"}})";

/// A SALAD network and the simulator on one host, in virtual time.
class SimulatedSalad : public ::testing::Test {
 protected:
  void run(SimulatorOptions options = {}, std::string_view script = "") {
    const ConfigNode node = support::config_of(kTable);
    ConfigReader reader(node, "", errors);
    const network::NetworkConfig config{"salad", IslandId{1}, reader, types, {}};
    network = std::move(networks::salad::kType.make(config, host).value());
    auto devices = networks::salad::read_salad_options(config, host.files).devices;
    auto steps = parse_script(script);
    ASSERT_TRUE(steps) << steps.error().text;
    simulator = std::make_unique<Simulator>(std::move(options), std::move(devices), *steps, types, host.time,
                                            host.files, Log(host.words, "simulator"));
    ASSERT_TRUE(simulator->open());
    ASSERT_TRUE(network->open());
  }
  std::vector<std::string> values(const std::string& wanted) const {
    std::vector<std::string> all;
    for (const auto& [device, updates] : host.all<model::Updates>()) {
      if (device == wanted) all.push_back(model::to_text(updates.readings.front().value));
    }
    return all;
  }
  std::map<std::string, std::uint64_t> counters() const { return host.all<model::State>().back().second.counters; }

  TypeCatalogue types;
  ConfigErrors errors;
  support::FakeHost host;
  std::unique_ptr<Simulator> simulator;
  std::unique_ptr<network::Network> network;
};

TEST_F(SimulatedSalad, PublishesEveryDeviceEachPeriodOnceAsked) {
  run();
  host.time.run_for(5100ms);
  EXPECT_EQ(simulator->counters().starts, 1u);
  EXPECT_THAT(host.all<model::Updates>(), SizeIs(4 * 10));
  EXPECT_THAT(values("7"), ::testing::Each("off"));
}

TEST_F(SimulatedSalad, IsSilentUntilItIsAsked) {
  run();
  network.reset();
  host.time.run_for(5s);
  EXPECT_EQ(simulator->counters().stops, 0u) << "the line was not yet there";
  EXPECT_EQ(simulator->counters().datagrams, 0u);
}

TEST_F(SimulatedSalad, ACommandsValueComesBack) {
  run();
  host.time.run_for(1s);
  Message message;
  message.destination.device = "46";
  message.body = model::Actuate{1, {Kind::kActuator, types.find("lamp")->id, "light"}, true};
  ASSERT_TRUE(network->send(message));
  host.time.run_for(1s);
  EXPECT_EQ(values("46").front(), "off");
  EXPECT_EQ(values("46").back(), "on");
  EXPECT_EQ(simulator->stored(46), Value(std::int64_t{1}));
  network.reset();
  host.time.run_for(1s);
  EXPECT_FALSE(simulator->publishing());
}

TEST_F(SimulatedSalad, PlaysItsScript) {
  run({}, "at 2s set 7 1 # the fridge\n\nat 4s set 7 0\nat 0s ramp 13 0 1 over 10s\nat 9s silence 2s\nat 20s repeat\n");
  host.time.run_for(1900ms);
  EXPECT_EQ(values("7").back(), "off");
  host.time.run_for(1s);
  EXPECT_EQ(values("7").back(), "on");
  EXPECT_EQ(values("13").back(), "0.25");
  host.time.run_for(2s);
  EXPECT_EQ(values("7").back(), "off");
  host.time.run_for(5s);
  const auto before = values("7").size();
  host.time.run_for(900ms);
  EXPECT_EQ(values("7").size(), before) << "silent";
  host.time.run_for(1s);
  EXPECT_EQ(values("13").back(), "1");
  host.time.run_for(11s);
  EXPECT_EQ(values("7").back(), "on") << "in its second round";
}

TEST_F(SimulatedSalad, ChanceIsTheSameForTheSameSeed) {
  std::vector<std::vector<std::string>> runs;
  for (int i = 0; i < 2; ++i) {
    host.delivered.clear();
    network.reset();
    simulator.reset();
    host.time.run_for(1s);
    SimulatorOptions options;
    options.noise = 30;
    options.seed = 42;
    run(options, "at 0s random 28 1 6 every 1s\n");
    host.time.run_for(30s);
    runs.push_back(values("28"));
    EXPECT_THAT(values("7"), ::testing::Contains("on")) << "noise flips switches";
  }
  EXPECT_EQ(runs[0], runs[1]);
  EXPECT_THAT(runs[0], ::testing::Contains("6"));
  EXPECT_THAT(runs[0], ::testing::Contains("1"));
}

TEST_F(SimulatedSalad, MisbehaviourIsCountedAndStopsNothing) {
  SimulatorOptions options;
  options.misbehaviours = *parse_misbehaviours({"all"});
  run(options, "at 5s garbage\nat 100s set 7 1\n");
  host.time.run_for(300s);
  auto counts = counters();
  for (const auto* kind : {"dropped-not-salad", "dropped-empty", "dropped-bad-number", "dropped-bad-id",
                           "dropped-bad-form", "dropped-unknown-id", "dropped-cut"}) {
    EXPECT_GT(counts[kind], 0u) << kind;
  }
  EXPECT_GT(simulator->counters().datagrams, 700u) << "bursts";
  EXPECT_LT(simulator->counters().publications, 500u) << "loss and silence";
  EXPECT_THAT(host.failures, ::testing::IsEmpty());
  simulator.reset();
  EXPECT_EQ(values("7").back(), "on");
}

TEST_F(SimulatedSalad, WaitsForAProxyWhoseNameIsNotKnownYet) {
  SimulatorOptions options;
  options.proxy_host = "island";
  run(options);
  host.time.run_for(5s);
  EXPECT_EQ(simulator->counters().datagrams, 0u);
  host.net.name("island", {"127.0.0.1"});
  host.time.run_for(2s);
  EXPECT_GT(simulator->counters().datagrams, 0u);
}

TEST(SimulatorScript, ARampMayGoDownAndARandomMayStand) {
  const auto steps = parse_script("at 0s ramp 7 100 -5 over 1s\nat 1s random 7 3 3 every 1s\n");
  ASSERT_TRUE(steps) << steps.error().text;
  EXPECT_EQ((*steps)[0].to, -5);
  EXPECT_THAT(parse_script("at 0s random 7 2 1 every 1s").error().text, HasSubstr("line 1: expected FROM <= TO"));
}

TEST(SimulatorAddress, IsLoopbackWhereTheProxyIs) {
  for (const auto* here : {"localhost", "127.0.0.1", "127.1.2.3"}) EXPECT_EQ(listening_address(here), "127.0.0.1");
  EXPECT_EQ(listening_address("::1"), "::1");
  for (const auto* there : {"island", "192.168.1.7", "127.example.org", "fe80::1", ""})
    EXPECT_EQ(listening_address(there), "");
}

TEST(SimulatorScript, SaysWhichLineIsWrong) {
  for (const auto* wrong :
       {"dance", "at", "at 2 set 7 1", "at 2s set 0 1", "at 2s set 7 x", "at 2s set 7", "at 0s ramp 7 0 1 over 0s",
        "at 0s random 7 0 1 every 0s", "at 0s random 7 2 1 every 1s", "at 0s random 7 -1e16 1 every 1s",
        "at 0s set 7 1e16", "at 0s set 7 1e999", "at 0s ramp 7 nan 1 over 1s", "at 0s ramp 7 0 inf over 1s",
        "at 0s repeat", "at 1s hold", "at 1s garbage please"}) {
    const auto steps = parse_script(std::string("at 1s garbage\n") + wrong);
    ASSERT_FALSE(steps) << wrong;
    EXPECT_THAT(steps.error().text, HasSubstr("line 2: "));
  }
  EXPECT_TRUE(parse_script("# nothing\n\r\n"));
  EXPECT_FALSE(parse_misbehaviours({"dance"}));
}

}  // namespace
}  // namespace rubicon::salad_simulator
