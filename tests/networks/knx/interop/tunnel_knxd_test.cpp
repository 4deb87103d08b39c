#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iostream>
#include <map>
#include <memory>

#include "networks/knx/line/tunnel_line.h"
#include "support/knxd.h"
#include "transport/worlds.h"

namespace rubicon::networks::knx::line {
namespace {

using namespace std::chrono_literals;
using support::Knxd;
using support::KnxdListener;
using support::KnxNetwork;
using ::testing::HasSubstr;

/// Our tunnel and knxd, which shares nothing with it, in a network of their own; knxtool is the other user of the bus.
class TunnelToKnxd : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!network.entered()) GTEST_SKIP() << network.reason();
    world = std::make_unique<transport::MachineWorld>();
    options.host = KnxNetwork::kAddress;
    options.limits.rate = 0;
  }
  void start_knxd(int users = 20) {
    knxd = std::make_unique<Knxd>(false, users);
    ASSERT_TRUE(world->until([&] { return knxd->ready(); })) << knxd->errors();
  }
  Scheduler& time() { return world->loop.scheduler(); }

  /// A lost line is reopened soon, as the supervisor does.
  std::unique_ptr<TunnelLine> make_line() {
    LineCallbacks calls;
    calls.received = [this](const wire::Telegram& telegram) { received.push_back(telegram); };
    calls.failed = [this](const Error&) {
      ++losses;
      reopening = time().after(500ms, [this] { EXPECT_TRUE(line->open()); });
    };
    return std::make_unique<TunnelLine>(options, time(), world->local, std::move(calls));
  }
  bool up() const { return line->state().phase == LineState::Phase::kUp; }
  void connect() {
    line = make_line();
    ASSERT_TRUE(line->open());
    ASSERT_TRUE(world->until([&] { return up(); })) << line->state().reason;
  }
  void write(std::uint16_t group, Bytes value) {
    wire::Telegram telegram;
    telegram.destination = wire::GroupAddress(group);
    telegram.payload = {std::move(value), false};
    line->send(telegram, time().now() + 1min, [this](SendOutcome outcome, std::string_view) { ++outcomes[outcome]; });
  }

  KnxNetwork network;
  std::unique_ptr<transport::MachineWorld> world;
  std::unique_ptr<Knxd> knxd;
  TunnelOptions options;
  std::vector<wire::Telegram> received;
  std::map<SendOutcome, int> outcomes;
  int losses = 0;
  Timer reopening;
  std::unique_ptr<TunnelLine> line;
};

TEST_F(TunnelToKnxd, WhatWeWriteIsHeardByKnxtool) {
  start_knxd();
  const KnxdListener listener(*knxd);
  connect();
  EXPECT_GE(number(line->state().own), 0x11c8);
  EXPECT_TRUE(world->until([&] {
    write(0x0a07, {0x0c, 0x33});
    return listener.heard().find("to 1/2/7: 0C 33") != std::string::npos;
  }));
  EXPECT_THAT(listener.heard(), HasSubstr("Write from " + to_string(line->state().own) + " to 1/2/7: 0C 33"));
  write(0x0a09, Bytes(20, 0x41));
  EXPECT_TRUE(world->until([&] { return listener.heard().find("to 1/2/9: 41 41") != std::string::npos; }));
  EXPECT_GE(outcomes[SendOutcome::kSent], 2);
  EXPECT_EQ(outcomes.size(), 1U);
}

TEST_F(TunnelToKnxd, WhatKnxtoolWritesReachesUs) {
  start_knxd();
  connect();
  EXPECT_EQ(knxd->tool("groupwrite", {"1/2/8", "0c", "65"}).code, 0);
  EXPECT_EQ(knxd->tool("groupswrite", {"1/2/3", "1"}).code, 0);
  EXPECT_EQ(knxd->tool("groupread", {"1/2/5"}).code, 0);
  ASSERT_TRUE(world->until([&] { return received.size() == 3; }));
  EXPECT_EQ(received[0].destination, wire::GroupAddress{0x0a08});
  EXPECT_EQ(received[0].payload, (wire::Payload{{0x0c, 0x65}, false}));
  EXPECT_EQ(received[1].payload, (wire::Payload{{1}, true}));
  EXPECT_EQ(received[2].service, wire::Service::kRead);
}

TEST_F(TunnelToKnxd, KilledAndStartedAgainItIsFoundWithoutALostWrite) {
  start_knxd();
  connect();
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    knxd->kill();
    write(0x0a07, {0, static_cast<std::uint8_t>(round)});
    ASSERT_TRUE(world->until([&] { return !up(); }));
    knxd->restart();
    ASSERT_TRUE(world->until([&] { return knxd->ready(); })) << knxd->errors();
    const auto back = time().now();
    ASSERT_TRUE(world->until([&] { return up(); })) << line->state().reason;
    EXPECT_LT(time().now() - back, 20s) << "it needs less than 2 s";
    ASSERT_TRUE(world->until([&] { return outcomes[SendOutcome::kSent] == round + 1; }));
  }
  EXPECT_GE(losses, kRounds);
  EXPECT_EQ(line->counters().at("reconnects"), static_cast<unsigned>(kRounds));
}

TEST_F(TunnelToKnxd, WithoutAFreeTunnelItWaitsAndSaysSo) {
  start_knxd(1);
  connect();
  const auto second = make_line();
  ASSERT_TRUE(second->open());
  ASSERT_TRUE(world->until([&] { return second->state().phase == LineState::Phase::kWaiting; }));
  EXPECT_THAT(second->state().reason, HasSubstr("status 24"));
  line.reset();
  EXPECT_TRUE(world->until([&] { return second->state().phase == LineState::Phase::kUp; }));
}

TEST_F(TunnelToKnxd, AWantedAddressAndRouteBackAreNegotiated) {
  start_knxd();
  options.wanted = wire::IndividualAddress{0x11cc};  // knxd refuses the extended form with status 22
  options.nat = TunnelOptions::Nat::kOn;
  connect();
  write(0x0a07, {1, 2});
  EXPECT_TRUE(world->until([&] { return outcomes[SendOutcome::kSent] == 1; }));
}

TEST_F(TunnelToKnxd, ThousandsOfTelegramsAreConfirmedOneByOne) {
  start_knxd();
  connect();
  constexpr int kCount = 3000;
  const auto begin = time().now();
  for (int i = 0; i < kCount; ++i)
    write(0x0a07, {static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i & 0xff)});
  ASSERT_TRUE(world->until([&] { return outcomes[SendOutcome::kSent] == kCount; }));
  const std::chrono::duration<double> took = time().now() - begin;
  std::cout << fmt::format("{:.0f} telegrams/s\n", kCount / took.count());
  EXPECT_EQ(line->counters().at("repeats"), 0U);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
