#include <gmock/gmock.h>
#include <malloc.h>
#include <openssl/crypto.h>

#include "networks/knx/line/secure_fixture.h"
#include "networks/knx/secure/guard_bench.h"

namespace rubicon::networks::knx::line {
namespace {

using Phase = LineState::Phase;
using ::testing::HasSubstr;

/// Over TCP (true) and over UDP.
class SecureTunnel : public SecureFixture, public testing::WithParamInterface<bool> {
 protected:
  SecureTunnel() {
    if (!GetParam()) options.via = TunnelOptions::Via::kUdp;
  }
};

TEST_P(SecureTunnel, TelegramsGoBothWays) {
  connect_secure();
  for (std::uint16_t i = 0; i < 50; ++i) {
    send(i);
    server->inject(0x1101, 0x0a08, 0x80, {2, static_cast<std::uint8_t>(i)});
  }
  time.run_for(5s);
  ASSERT_EQ(outcomes.size(), 50U);
  ASSERT_EQ(received.size(), 50U);
  for (std::uint16_t i = 0; i < 50; ++i) {
    EXPECT_EQ(sent(i), SendOutcome::kSent);
    EXPECT_EQ(received[i].payload.bytes[1], i);
  }
  EXPECT_EQ(count("secure-sessions"), 1U);
  EXPECT_EQ(count("secure-unverified"), 0U);
  EXPECT_EQ(server->counters.plain_frames, 0U) << "nothing was sent in clear";
}

TEST_P(SecureTunnel, ItLivesForHoursAndIsKeptAlive) {
  connect_secure();
  time.run_for(6h);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(count("reconnects"), 0U);
  EXPECT_GT(server->sessions()->counters.keep_alives, 300U);
  EXPECT_EQ(server->sessions()->counters.timeouts, 0U);
}

TEST_P(SecureTunnel, EveryExitClosesTunnelAndSession) {
  connect_secure();
  line.reset();
  time.run_for(1s);
  EXPECT_TRUE(server->channels().empty());
  EXPECT_EQ(sessions(), 0U);
  EXPECT_EQ(server->sessions()->counters.closes, 1U);
  EXPECT_GE(server->counters.disconnects, 1U);
  make_line();
  ASSERT_TRUE(line->open());
  time.run_for(100ms);
  ASSERT_EQ(phase(), Phase::kUp);
  server->disconnect_all();  // the tunnel ends, the session is ours to close
  time.run_for(100ms);
  EXPECT_EQ(sessions(), 0U);
  EXPECT_EQ(server->sessions()->counters.closes, 2U);
}

TEST_P(SecureTunnel, ASessionThatTheServerEndsIsOpenedAgain) {
  connect_secure();
  for (const auto status : {secure::Status::kTimeout, secure::Status::kClose, secure::Status::kUnauthenticated}) {
    time.run_for(20s);
    server->sessions()->end_all(status);
    send(static_cast<std::uint16_t>(status));
    time.run_for(2s);
    EXPECT_EQ(phase(), Phase::kUp);
    EXPECT_EQ(sent(static_cast<std::uint16_t>(status)), SendOutcome::kSent);
  }
  EXPECT_EQ(count("reconnects"), 3U);
  ASSERT_EQ(failures.size(), 3U);
  EXPECT_THAT(failures[0].text, HasSubstr("session status 3"));
  EXPECT_THAT(failures[1].text, HasSubstr("session status 5"));
  EXPECT_THAT(failures[2].text, HasSubstr("session status 2"));
}

TEST_P(SecureTunnel, ASessionThatIsForgottenWithoutAMessageIsOpenedAgain) {
  connect_secure();
  server->sessions()->end_all({});
  time.run_for(4min);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(count("reconnects"), 1U);
}

TEST_P(SecureTunnel, AServerThatRestartsIsFoundAgain) {
  connect_secure();
  for (std::uint16_t round = 0; round < 10; ++round) {
    server->stop();
    send(round);
    time.run_for(500ms);
    server->start();
    time.run_for(4min);
    EXPECT_EQ(phase(), Phase::kUp) << round;
  }
  EXPECT_EQ(count("reconnects"), 10U);
  EXPECT_EQ(server->sessions()->counters.authenticated, 11U);
}

TEST_P(SecureTunnel, AClientThatFightsForItsSessionWaits) {
  open();
  for (int i = 0; i < 6 && phase() != Phase::kWaiting; ++i) {
    server->sessions()->end_all(secure::Status::kClose);
    time.run_for(1s);
  }
  EXPECT_EQ(phase(), Phase::kWaiting);
  EXPECT_THAT(reason(), HasSubstr("two clients"));
}

TEST_P(SecureTunnel, ASessionThatIsForgottenAtOnceIsNotOpenedAgainWithoutPause) {
  open();
  const auto begin = server->sessions()->counters.requests;
  for (int i = 0; i < 600; ++i) {
    if (phase() == Phase::kUp) server->sessions()->end_all(secure::Status::kUnauthenticated);
    time.run_for(100ms);
  }
  EXPECT_LE(server->sessions()->counters.requests, begin + 6);
}

TEST_P(SecureTunnel, AWrongUserOrPasswordIsAConfigurationErrorAndRetriedSlowly) {
  for (const bool wrong_user : {true, false}) {
    server.reset();
    options.secure->user = wrong_user ? 99 : 2;
    options.secure->user_key.key = key(wrong_user ? 2 : 77);
    open();
    server->sessions()->unknown_user_status = 2;
    EXPECT_EQ(phase(), Phase::kRefused);
    EXPECT_THAT(reason(), HasSubstr(wrong_user ? "user 99" : "user 2"));
    EXPECT_THAT(reason(), HasSubstr("password"));
    EXPECT_TRUE(failures.empty());
    const auto requests = server->sessions()->counters.requests;
    time.run_for(59s);
    EXPECT_EQ(server->sessions()->counters.requests, requests);
    time.run_for(301s);
    EXPECT_EQ(server->sessions()->counters.requests, requests + 2);
    EXPECT_EQ(sessions(), 0U);
    line.reset();
  }
}

TEST_P(SecureTunnel, ACorrectedPasswordIsFoundByTheSlowRetry) {
  options.secure->user_key.key = key(77);
  open();
  EXPECT_EQ(phase(), Phase::kRefused);
  server.reset();
  secured.users[0].key = key(77);
  make_secure_server();
  time.run_for(61s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_P(SecureTunnel, TheOtherFormOfAPasswordIsTriedOnceAndThenKept) {
  options.secure->user_key = {key(77), std::vector{key(2)}};
  connect_secure();
  EXPECT_EQ(server->sessions()->counters.refused, 1U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_THAT(notes[0].second, HasSubstr("beyond ASCII"));
  for (const auto& state : states) EXPECT_TRUE(state.phase != Phase::kRefused && state.phase != Phase::kWaiting);
  server->disconnect_all();
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(server->sessions()->counters.refused, 1U) << "the form that worked is used again";
}

TEST_P(SecureTunnel, WhereAnotherFormIsTakenLaterItIsFoundAtOnceToo) {
  options.secure->user_key = {key(77), std::vector{key(2)}};
  connect_secure();
  server.reset();
  secured.users[0].key = key(77);
  make_secure_server();
  states.clear();
  for (int i = 0; i < 300 && server->sessions()->counters.authenticated == 0; ++i) {
    if (!failures.empty()) std::ignore = line->open();
    failures.clear();
    time.run_for(1s);
  }
  EXPECT_EQ(phase(), Phase::kUp);
  for (const auto& state : states) EXPECT_NE(state.phase, Phase::kRefused) << state.reason;
}

TEST_P(SecureTunnel, WithoutAFormThatWorksItIsRefused) {
  options.secure->user_key = {key(77), std::vector{key(78)}};
  open();
  EXPECT_EQ(phase(), Phase::kRefused);
  EXPECT_EQ(server->sessions()->counters.refused, 2U);
  time.run_for(61s);
  EXPECT_EQ(server->sessions()->counters.refused, 4U);
}

TEST_P(SecureTunnel, AnotherDeviceIsNamedAndNotAskedAgainSoon) {
  make_secure_server();
  server->sessions()->other_device_code = key(0x99);
  open();
  if (!GetParam()) time.run_for(10s);  // over UDP the response may be forged
  EXPECT_EQ(phase(), Phase::kRefused);
  EXPECT_THAT(reason(), HasSubstr("not the device"));
  const auto requests = server->sessions()->counters.requests;
  time.run_for(59s);
  EXPECT_EQ(server->sessions()->counters.requests, requests);
  EXPECT_EQ(server->sessions()->counters.refused + server->sessions()->counters.authenticated, 0U);
}

TEST_P(SecureTunnel, WithoutADevicePasswordItWarns) {
  options.secure->device_code.reset();
  connect_secure();
  EXPECT_EQ(count("secure-unverified"), 1U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].first, "secure-unverified");
  EXPECT_THAT(notes[0].second, HasSubstr("not verified"));
}

TEST_P(SecureTunnel, WithoutAFreeSessionItWaits) {
  secured.sessions = 0;
  open();
  if (!GetParam()) time.run_for(10s);  // over UDP the response may be forged
  EXPECT_EQ(phase(), Phase::kWaiting);
  EXPECT_THAT(reason(), HasSubstr("all secure sessions"));
  time.run_for(30s);
  EXPECT_GT(server->sessions()->counters.requests, 3U);
}

TEST_P(SecureTunnel, AServerWithoutSecurityIsSuspectedOfIt) {
  make_server();
  open();
  time.run_for(11s);
  ASSERT_FALSE(failures.empty());
  EXPECT_THAT(failures[0].text, HasSubstr("does it support KNX IP Secure?"));
  EXPECT_EQ(server->counters.connects, 0U) << "it is never asked for a plain tunnel";
}

TEST_P(SecureTunnel, AnUnansweredAuthenticationEnds) {
  make_secure_server();
  server->sessions()->answers_authentication = false;
  open();
  time.run_for(10s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, HasSubstr("authentication"));
}

TEST_P(SecureTunnel, AWantedAddressOfAnotherUserIsGivenUpOnce) {
  with.wanted_addresses = true;
  options.secure->user = 3;
  options.secure->user_key.key = key(3);
  options.wanted = wire::IndividualAddress{0x11c8};
  connect_secure();
  EXPECT_EQ(to_string(line->state().own), "1.1.201");
  EXPECT_EQ(server->counters.connects, 2U);
  EXPECT_EQ(count("other-tunnel-address"), 1U);
}

TEST_P(SecureTunnel, AUserWithoutATunnelIsAConfigurationError) {
  make_secure_server();
  server->connect_status = 0x28;
  open();
  EXPECT_EQ(phase(), Phase::kRefused);
  EXPECT_THAT(reason(), HasSubstr("user 2 has no tunnel there"));
  EXPECT_EQ(sessions(), 0U);
}

TEST_P(SecureTunnel, AllTunnelsTakenIsNamed) {
  with.tunnels = 0;
  open();
  EXPECT_EQ(phase(), Phase::kWaiting);
  EXPECT_THAT(reason(), HasSubstr("status 24"));
}

TEST_P(SecureTunnel, PlainFramesOnASecuredLineAreDroppedAndCounted) {
  connect_secure();
  const auto channel = server->channels().at(0);
  server->send_in_clear({0x06, 0x10, 0x02, 0x09, 0x00, 0x10, channel, 0, 8, 1, 0, 0, 0, 0, 0, 0});
  server->send_in_clear(*base::from_hex("06100420001504010000 2900bce011010a05010081"));
  time.run_for(100ms);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_TRUE(received.empty());
  EXPECT_EQ(count("secure-plain-frames"), 2U);
  EXPECT_EQ(count("reconnects"), 0U);
}

TEST_P(SecureTunnel, APlainLineIsToldWhatToConfigure) {
  options.secure.reset();
  open();
  EXPECT_EQ(phase(), Phase::kRefused);
  EXPECT_THAT(reason(), HasSubstr("status 22"));
  EXPECT_THAT(reason(), HasSubstr("keyring"));
  EXPECT_THAT(reason(), HasSubstr("tunnel-tcp"));
}

TEST_P(SecureTunnel, MayBeDestroyedInAnyStateChange) {
  make_secure_server();
  for (const auto last : {Phase::kConnecting, Phase::kUp}) {
    std::unique_ptr<TunnelLine> one;
    LineCallbacks calls;
    calls.changed = [&](const LineState& state) {
      if (state.phase == last) one.reset();
    };
    one = std::make_unique<TunnelLine>(options, time, transports, std::move(calls));
    ASSERT_TRUE(one->open());
    time.run_for(1s);
    EXPECT_EQ(one, nullptr);
  }
  time.run_for(2min);
  EXPECT_EQ(sessions(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Ways, SecureTunnel, testing::Bool(),
                         [](const auto& way) { return std::string(way.param ? "Tcp" : "Udp"); });

class SecureRefusals : public SecureFixture {};

TEST_F(SecureRefusals, TenThousandLeaveNothingBehind) {
  options.secure->user_key.key = key(77);
  make_secure_server();
  std::size_t heap = 0, secrets = 0;
  for (int i = 0; i < 10'000; ++i) {
    if (i == 1000) {
      heap = ::mallinfo2().uordblks;
      secrets = ::CRYPTO_secure_used();
    }
    TunnelLine one(options, time, transports, {});
    ASSERT_TRUE(one.open());
    time.run_for(10ms);
    ASSERT_EQ(one.state().phase, Phase::kRefused) << i;
  }
  time.run_for(1s);
  EXPECT_EQ(server->sessions()->counters.refused, 10'000U);
  EXPECT_EQ(sessions(), 0U);
  EXPECT_TRUE(server->channels().empty());
  EXPECT_EQ(server->connections(), 0U);
  EXPECT_LT(::mallinfo2().uordblks, heap + 65'536) << "since the 1,000th";
  EXPECT_EQ(::CRYPTO_secure_used(), secrets) << "keys in the secure heap";
}

/// Datagrams get lost, doubled and reordered, each way.
class SecureLoss : public SecureFixture, public testing::WithParamInterface<unsigned> {
 protected:
  static constexpr std::uint16_t kWrites = 200;

  SecureLoss() {
    options.via = TunnelOptions::Via::kUdp;
    reopen_pause = 200ms;
  }
  void run_writes(support::KnxServer::Weather weather) {
    connect_secure();
    weather.seed = GetParam();
    server->set_weather(weather);
    const auto begin = time.now();
    for (std::uint16_t i = 0; i < kWrites; ++i) send(i, 120s);
    while (outcomes.size() < kWrites && time.now() - begin < 90s) time.run_for(10ms);
  }
  void expect_all_delivered() {
    ASSERT_EQ(outcomes.size(), kWrites);
    const auto times = arrivals();
    for (std::uint16_t i = 0; i < kWrites; ++i) {
      ASSERT_TRUE(times.contains(i)) << i;
      EXPECT_TRUE(sent(i) == SendOutcome::kSent || sent(i) == SendOutcome::kUnconfirmed)
          << i << ": " << outcomes[i].why;
    }
  }
};

TEST_P(SecureLoss, ThreePercentEachWayLoseNothing) {
  run_writes({.loss = 0.03});
  expect_all_delivered();
  EXPECT_GT(count("repeats") + count("missing-acks"), 0U);
}

TEST_P(SecureLoss, DuplicatesAreReplaysAndReorderedFramesAreLost) {
  run_writes({.loss = 0.03, .duplicate = 0.05, .reorder = 0.03});
  expect_all_delivered();
  EXPECT_GT(count("secure-replays"), 0U);
  EXPECT_EQ(count("secure-wrong-mac"), 0U);
}

TEST_P(SecureLoss, ASilentSessionLivesForHours) {
  connect_secure();
  server->set_weather({.loss = 0.03, .seed = GetParam()});
  time.run_for(6h);
  EXPECT_EQ(count("reconnects"), 0U);
  EXPECT_EQ(server->sessions()->counters.timeouts, 0U);
}

TEST_P(SecureLoss, AHandshakeUnderLossSucceedsInTheEnd) {
  make_secure_server();
  server->set_weather({.loss = 0.3, .seed = GetParam()});
  make_line();
  ASSERT_TRUE(line->open());
  for (int i = 0; i < 600 && count("secure-sessions") == 0; ++i) time.run_for(100ms);
  EXPECT_GE(count("secure-sessions"), 1U) << reason();
}

INSTANTIATE_TEST_SUITE_P(Seeds, SecureLoss, testing::Values(1U, 2U, 3U, 4U, 5U, 6U));

class SecureApdu : public SecureFixture {};

TEST_F(SecureApdu, IsAskedForThroughTheSession) {
  secure::GuardBench bench;
  options.guard = &bench.start();
  make_secure_server();
  server->max_apdu = 15;
  connect();
  send(1, write(0x0a07, {0x0c, 0x33}));
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kRefused);
  EXPECT_THAT(outcomes.at(1).why, HasSubstr("at most 15 bytes"));
  EXPECT_EQ(server->counters.plain_frames, 0U);
  line.reset();  // before the guard
}

}  // namespace
}  // namespace rubicon::networks::knx::line
