#include "apps/simulators/knx/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "networks/knx/line/tunnel_line.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"

namespace rubicon::knx_simulator {
namespace {

using namespace std::chrono_literals;
using namespace networks::knx::wire;
using namespace networks::knx::line;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::string_view kBus =
    "group 1/0/1 1.001 off state 1/0/2\n"
    "group 1/2/7 9.001 21.5\n"
    "group 1/3/1 5.010 7 write-only\n";

/// The simulator on one host and clients on another, in virtual time.
class SimulatedKnx : public testing::Test {
 protected:
  SimulatedKnx() {
    host.join(net, "10.0.0.9");
    client.join(net, "10.0.0.2");
    options.server.at.address = "10.0.0.9";
  }

  void run(const std::string& script = "") {
    auto read = parse_script(std::string(kBus) + script);
    ASSERT_TRUE(read) << read.error().text;
    simulator = std::make_unique<Simulator>(options, std::move(*read), time, host, Log(log, "simulator"));
    const auto opened = simulator->open();
    ASSERT_TRUE(opened) << opened.error().text;
  }
  LineCallbacks calls() {
    LineCallbacks calls;
    calls.received = [this](const Telegram& one) { heard.push_back(text_of(one)); };
    calls.failed = [this](const Error&) { ++failures; };
    return calls;
  }
  void connect(bool tcp = false) {
    TunnelOptions tunnel;
    tunnel.host = "10.0.0.9";
    if (tcp) tunnel.via = TunnelOptions::Via::kTcp;
    tunnel.limits.rate = 0;
    line = std::make_unique<TunnelLine>(tunnel, time, client, calls());
    ASSERT_TRUE(line->open());
    time.run_for(100ms);
    ASSERT_EQ(line->state().phase, LineState::Phase::kUp) << line->state().reason;
  }
  void send(Service service, std::string_view group, Payload payload = {}) {
    Telegram telegram;
    telegram.service = service;
    telegram.destination = parse_group(group).value();
    telegram.payload = std::move(payload);
    line->send(telegram, time.now() + 1min,
               [this](SendOutcome outcome, std::string_view) { outcomes.push_back(outcome); });
    time.run_for(1s);
  }
  static std::string text_of(const Telegram& one) {
    return (one.service == Service::kRead    ? "read "
            : one.service == Service::kWrite ? "write "
                                             : "response ") +
           to_string(one.destination) + " " + base::to_hex(one.payload.bytes);
  }

  base::VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MemoryTransports host, client;
  support::CollectingLog log;
  SimulatorOptions options;
  std::unique_ptr<Simulator> simulator;
  std::unique_ptr<Line> line;
  std::vector<std::string> heard;
  std::vector<SendOutcome> outcomes;
  int failures = 0;
};

TEST_F(SimulatedKnx, AnActuatorTakesACommandAndReportsItsState) {
  run();
  connect();
  send(Service::kWrite, "1/0/1", {{1}, true});
  EXPECT_THAT(outcomes, ElementsAre(SendOutcome::kSent));
  EXPECT_THAT(heard, ElementsAre("write 1/0/2 01"));
  heard.clear();
  send(Service::kRead, "1/0/2");
  EXPECT_THAT(heard, ElementsAre("response 1/0/2 01"));
}

TEST_F(SimulatedKnx, AnswersReadsOverTcpToo) {
  run();
  connect(true);
  send(Service::kRead, "1/2/7");
  send(Service::kRead, "1/3/1");
  send(Service::kRead, "7/7/7");
  EXPECT_THAT(heard, ElementsAre("response 1/2/7 0c33"));
  EXPECT_EQ(simulator->bus().counters().answered, 1U);
  EXPECT_EQ(simulator->bus().counters().ignored, 2U);
}

TEST_F(SimulatedKnx, MoreTcpConnectionsThanItsBoundAreRefusedUntilOneEnds) {
  run();
  int lost = 0;
  std::vector<std::unique_ptr<transport::TcpStream>> streams;
  const auto open_one = [&] {
    transport::TcpOptions to;
    to.remote = simulator->server().local();
    transport::TcpCallbacks calls;
    calls.failed = [&lost](const Error&) { ++lost; };
    auto stream = client.open_tcp(to, std::move(calls));
    ASSERT_TRUE(stream) << stream.error().text;
    streams.push_back(std::move(*stream));
    time.run_for(1ms);
  };
  const auto bound = options.server.tunnels + Server::kSpareConnections;
  for (std::size_t i = 0; i < bound; ++i) open_one();
  EXPECT_EQ(lost, 0);
  open_one();
  EXPECT_EQ(lost, 1);
  EXPECT_EQ(simulator->server().counters.refused_connections, 1U);
  streams.front().reset();
  time.run_for(1s);
  connect(true);
  send(Service::kRead, "1/2/7");
  EXPECT_THAT(heard, ElementsAre("response 1/2/7 0c33"));
}

TEST_F(SimulatedKnx, IgnoresAValueOfAnotherLength) {
  run();
  connect();
  send(Service::kWrite, "1/2/7", {{1}, true});
  EXPECT_EQ(*simulator->bus().value(parse_group("1/2/7").value()), (Payload{{0x0c, 0x33}, false}));
  EXPECT_EQ(simulator->bus().counters().ignored, 1U);
}

TEST_F(SimulatedKnx, PlaysItsScriptAgainAndAgain) {
  run("at 2s write 1/2/7 20\nat 3s set 1/2/7 22\nat 4s read 1/0/2\nat 5s write 1/0/1 on\nat 10s repeat\n");
  connect();
  time.run_for(8s);
  EXPECT_THAT(heard, ElementsAre("write 1/2/7 07d0", "read 1/0/2 ", "write 1/0/1 01", "write 1/0/2 01"));
  send(Service::kRead, "1/2/7");
  EXPECT_EQ(heard.back(), "response 1/2/7 0c4c");
  heard.clear();
  time.run_for(4s);
  EXPECT_THAT(heard, ElementsAre("write 1/2/7 07d0"));
}

TEST_F(SimulatedKnx, ARampSendsEachSecondAndEndsExactly) {
  run("at 1s ramp 1/2/7 20 22 over 2500ms\n");
  connect();
  time.run_for(5s);
  EXPECT_THAT(heard, ElementsAre("write 1/2/7 07d0", "write 1/2/7 0c10", "write 1/2/7 0c38", "write 1/2/7 0c4c"));
}

TEST_F(SimulatedKnx, SensorsSendNoiseAndWavesWithinTheirBounds) {
  run("group 2/0/1 5.010 100 every 1s noise 5\ngroup 2/0/2 5.010 0 every 1s wave 0 200 over 1min\n");
  connect();
  time.run_for(2min);
  std::set<int> noise, wave;
  for (const auto& one : heard) {
    const auto value = std::stoi(one.substr(one.rfind(' ') + 1), nullptr, 16);
    (one.starts_with("write 2/0/1") ? noise : wave).insert(value);
  }
  EXPECT_GE(*noise.begin(), 95);
  EXPECT_LE(*noise.rbegin(), 105);
  EXPECT_GT(noise.size(), 5U);
  EXPECT_LE(*wave.begin(), 1);
  EXPECT_GE(*wave.rbegin(), 199);
  EXPECT_EQ(heard.size(), 240U);
}

TEST_F(SimulatedKnx, ChanceIsTheSameForTheSameSeed) {
  std::vector<std::vector<std::string>> runs;
  for (int i = 0; i < 2; ++i) {
    line.reset();
    simulator.reset();
    heard.clear();
    options.seed = 42;
    run("group 2/0/1 9.001 20 every 1s noise 3\n");
    connect();
    time.run_for(20s);
    runs.push_back(heard);
  }
  EXPECT_EQ(runs[0], runs[1]);
}

TEST_F(SimulatedKnx, ASilentBusNeitherSendsNorAnswers) {
  run("at 1s silence 10s\nat 2s write 1/2/7 20\n");
  connect();
  time.run_for(2s);
  send(Service::kRead, "1/2/7");
  EXPECT_THAT(outcomes, ElementsAre(SendOutcome::kSent)) << "the server confirms all the same";
  EXPECT_THAT(heard, IsEmpty());
  time.run_for(10s);
  send(Service::kRead, "1/2/7");
  EXPECT_THAT(heard, ElementsAre("response 1/2/7 07d0"));
}

TEST_F(SimulatedKnx, EndsItsTunnelsAndStopsWhenTheScriptSaysSo) {
  run("at 1s disconnect\nat 3s stop 10s\n");
  connect();
  time.run_for(1s);
  EXPECT_EQ(failures, 1);
  connect();
  time.run_for(2s);
  EXPECT_FALSE(simulator->server().running());
  time.run_for(10s);
  EXPECT_TRUE(simulator->server().running());
}

TEST_F(SimulatedKnx, ARouterPassesTelegramsBetweenItsGroupAndTheTunnels) {
  options.routing.emplace();
  run();
  connect();
  transport::MemoryTransports other;
  other.join(net, "10.0.0.3");
  std::vector<std::string> routed;
  LineCallbacks router_calls;
  router_calls.received = [&](const Telegram& one) { routed.push_back(text_of(one)); };
  RoutingLine router(time, other, {}, std::move(router_calls));
  ASSERT_TRUE(router.open());
  time.run_for(1s);
  send(Service::kWrite, "1/0/1", {{1}, true});
  EXPECT_THAT(routed, ElementsAre("write 1/0/1 01", "write 1/0/2 01"));
  heard.clear();
  Telegram read;
  read.service = Service::kRead;
  read.destination = parse_group("1/2/7").value();
  router.send(read, time.now() + 1min, {});
  time.run_for(1s);
  EXPECT_THAT(routed, Contains("response 1/2/7 0c33"));
  EXPECT_THAT(heard, ElementsAre("read 1/2/7 ", "response 1/2/7 0c33"));
}

TEST_F(SimulatedKnx, ATakenPortIsBusy) {
  run();
  const auto first = std::move(simulator);
  auto read = parse_script(kBus);
  Simulator second(options, std::move(*read), time, host, Log(log, "simulator"));
  const auto opened = second.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kBusy);
}

}  // namespace
}  // namespace rubicon::knx_simulator
