#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iostream>
#include <map>
#include <memory>

#include "apps/simulators/knx/server.h"
#include "networks/knx/line/tunnel_line.h"
#include "networks/knx/secure/passwords.h"
#include "support/private_network.h"
#include "transport/worlds.h"

namespace rubicon::networks::knx::line {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr std::string_view kServer = R"(# passwords of the simulated interface
device-password auth code
user 2 1.1.200 tunnel two
user 3 any schl?ssel
)";

/// Our secure tunnel and a strict server of KNX IP Secure over true sockets, in a network of their own. Over TCP (true)
/// and over UDP.
class SecureTunnelOverSockets : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!network.entered()) GTEST_SKIP() << network.reason();
    world = std::make_unique<transport::MachineWorld>();
    knx_simulator::ServerOptions with;
    with.secure = knx_simulator::parse_secure_options(kServer).value();
    server = std::make_unique<knx_simulator::Server>(time(), world->local, std::move(with));
    server->on_frame = [this](const knx_simulator::ClientFrame& frame) { heard.push_back(frame); };
    ASSERT_TRUE(server->start());
    options.host = "127.0.0.1";
    options.via = GetParam() ? TunnelOptions::Via::kTcp : TunnelOptions::Via::kUdp;
    options.limits.rate = 0;
    options.secure = keys(2, "tunnel two", "auth code");
  }
  static secure::SessionKeys keys(std::uint8_t user, std::string_view password, std::string_view code) {
    return {user, secure::user_key(secure::Secret::of_text(password)).value(),
            secure::device_code(secure::Secret::of_text(code)).value()};
  }
  Scheduler& time() { return world->loop.scheduler(); }
  void open() {
    LineCallbacks calls;
    calls.received = [this](const wire::Telegram& telegram) { received.push_back(telegram); };
    calls.failed = [this](const Error& why) {
      losses.push_back(why.text);
      reopening = time().after(100ms, [this] { EXPECT_TRUE(line->open()); });
    };
    line = std::make_unique<TunnelLine>(options, time(), world->local, std::move(calls));
    ASSERT_TRUE(line->open());
  }
  bool in(LineState::Phase phase) const { return line->state().phase == phase; }
  void connect() {
    open();
    ASSERT_TRUE(world->until([&] { return in(LineState::Phase::kUp); })) << line->state().reason;
  }
  void write(int value) {
    wire::Telegram telegram;
    telegram.destination = wire::GroupAddress(0x0a07);
    telegram.payload = {{static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value & 0xff)}, false};
    line->send(telegram, time().now() + 1min, [this](SendOutcome outcome, std::string_view) { ++outcomes[outcome]; });
  }

  support::PrivateNetwork network;
  std::unique_ptr<transport::MachineWorld> world;
  std::unique_ptr<knx_simulator::Server> server;
  std::vector<knx_simulator::ClientFrame> heard;
  TunnelOptions options;
  std::vector<wire::Telegram> received;
  std::map<SendOutcome, int> outcomes;
  std::vector<std::string> losses;
  Timer reopening;
  std::unique_ptr<TunnelLine> line;
};

TEST_P(SecureTunnelOverSockets, ThousandsOfTelegramsAreConfirmedOneByOne) {
  connect();
  EXPECT_EQ(to_string(line->state().own), "1.1.200");
  constexpr int kCount = 2000;
  const auto begin = time().now();
  for (int i = 0; i < kCount; ++i) write(i);
  ASSERT_TRUE(world->until([&] { return outcomes[SendOutcome::kSent] == kCount; }));
  const std::chrono::duration<double> took = time().now() - begin;
  std::cout << fmt::format("{:.0f} telegrams/s\n", kCount / took.count());
  ASSERT_EQ(heard.size(), std::size_t{kCount});
  for (int i = 0; i < kCount; ++i) EXPECT_EQ(heard[static_cast<std::size_t>(i)].tpdu.back(), i & 0xff);
  EXPECT_EQ(server->counters.plain_frames, 0U);
  EXPECT_EQ(server->sessions()->counters.wrong_mac + server->sessions()->counters.replays, 0U);
}

TEST_P(SecureTunnelOverSockets, TelegramsOfTheBusReachUs) {
  connect();
  for (std::uint8_t i = 0; i < 100; ++i)
    server->send_to_clients({0x29, 0, 0xbc, 0xe0, 0x11, 1, 0x0a, 8, 3, 0, 0x80, 0x0c, i});
  ASSERT_TRUE(world->until([&] { return received.size() == 100; }));
  for (std::uint8_t i = 0; i < 100; ++i) EXPECT_EQ(received[i].payload.bytes[1], i);
}

TEST_P(SecureTunnelOverSockets, APasswordBeyondAsciiIsTriedInBothForms) {
  options.secure = keys(3, "schl\u00fcssel", "auth code");
  connect();
  EXPECT_EQ(server->sessions()->counters.refused, 1U);
}

TEST_P(SecureTunnelOverSockets, RefusalsAreNamed) {
  options.secure = keys(2, "wrong", "auth code");
  open();
  ASSERT_TRUE(world->until([&] { return in(LineState::Phase::kRefused); }));
  EXPECT_THAT(line->state().reason, HasSubstr("user 2"));
  options.secure = keys(2, "tunnel two", "wrong");
  open();
  ASSERT_TRUE(world->until([&] { return in(LineState::Phase::kRefused); }));
  EXPECT_THAT(line->state().reason, HasSubstr("not the device"));
  options.secure.reset();
  open();
  ASSERT_TRUE(world->until([&] { return in(LineState::Phase::kRefused); }));
  EXPECT_THAT(line->state().reason, HasSubstr("keyring"));
  EXPECT_TRUE(losses.empty());
}

TEST_P(SecureTunnelOverSockets, StoppedAndStartedAgainItIsFoundWithoutALostWrite) {
  connect();
  for (int round = 0; round < 5; ++round) {
    server->stop();
    write(round);
    ASSERT_TRUE(world->until([&] { return !in(LineState::Phase::kUp); }));
    ASSERT_TRUE(server->start());
    ASSERT_TRUE(world->until([&] { return outcomes[SendOutcome::kSent] == round + 1; })) << line->state().reason;
  }
  EXPECT_EQ(line->counters().at("reconnects"), 5U);
  line.reset();
  EXPECT_TRUE(world->until([&] { return server->channels().empty() && server->sessions()->size() == 0; }));
}

INSTANTIATE_TEST_SUITE_P(Ways, SecureTunnelOverSockets, testing::Bool(),
                         [](const auto& way) { return std::string(way.param ? "Tcp" : "Udp"); });

}  // namespace
}  // namespace rubicon::networks::knx::line
