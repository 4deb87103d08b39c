#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "networks/knx/line/line_fixture.h"
#include "networks/knx/line/router.h"
#include "networks/knx/secure/guard_bench.h"

namespace rubicon::networks::knx::line {
namespace {

using secure::GuardBench;
using secure::indication;
using secure::kOther;
using secure::kSecuredGroup;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A tunnel whose line has a guard of 1/2/7; 2/0/1 is not secured.
class GuardedTunnel : public LineFixture {
 protected:
  GuardedTunnel() {
    options.guard = &bench.start();
    make_server();
    server->max_apdu = 254;
  }

  wire::Telegram value(std::uint16_t group, Bytes bytes = {0x0c, 0x33}) { return write(group, std::move(bytes)); }
  static std::uint64_t sequence_of(const support::KnxServer::Heard& heard) {
    return secure::read_secured(heard.tpdu).value().sequence;
  }

  GuardBench bench;
};

TEST_F(GuardedTunnel, ASecuredTelegramLeavesEncryptedAndItsConfirmationIsRecognised) {
  connect();
  send(1, value(0x0a07));
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  ASSERT_THAT(server->heard(), SizeIs(1));
  const auto& heard = server->heard()[0];
  EXPECT_TRUE(secure::is_secured(heard.tpdu));
  EXPECT_EQ(wire::read_data_frame(heard.cemi)->source, line->state().own) << "receivers know the sender by it";
  EXPECT_TRUE(wire::read_data_frame(heard.cemi)->extended());
  GuardBench receiver;
  auto keys = secure::one_group();
  keys.groups[kSecuredGroup].senders = {line->state().own};
  const auto telegram = secure::opened(receiver.start(keys, kOther), heard.cemi);
  ASSERT_TRUE(telegram) << telegram.error().why;
  EXPECT_EQ(telegram->payload.bytes, (Bytes{0x0c, 0x33}));
  EXPECT_EQ(count("data-secure-sent"), 1U);
}

/// An interface for standard frames only (max APDU 15, as many have): values of two bytes do not fit once secured.
class ShortFrames : public GuardedTunnel, public testing::WithParamInterface<TunnelOptions::Via> {
 protected:
  ShortFrames() {
    server->max_apdu = 15;
    options.via = GetParam();
  }
};

TEST_P(ShortFrames, RefuseWhatIsTooLongOnceItIsSecured) {
  make_line();
  ASSERT_TRUE(line->open());
  send(1, value(0x0a07));
  send(2, value(0x0a07, {0x33}));
  send(3, value(0x1001));
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kRefused);
  EXPECT_THAT(outcomes.at(1).why, HasSubstr("1/2/7 is secured: a value of 2 bytes then needs 16, and the interface "
                                            "carries telegrams of at most 15 bytes"));
  EXPECT_EQ(sent(2), SendOutcome::kSent);
  EXPECT_EQ(sent(3), SendOutcome::kSent) << "not secured";
  EXPECT_THAT(server->heard(), SizeIs(2));
  EXPECT_EQ(count("data-secure-sent"), 1U);
}

TEST_P(ShortFrames, SendWhatTheConfigurationSaysTheyCarry) {
  options.max_apdu = 55;
  make_line();
  ASSERT_TRUE(line->open());
  send(1, value(0x0a07));
  send(2, value(0x0a07, Bytes(60, 0x33)));
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(sent(2), SendOutcome::kRefused);
  EXPECT_THAT(outcomes.at(2).why, HasSubstr("at most 55 bytes"));
}

INSTANTIATE_TEST_SUITE_P(Vias, ShortFrames, testing::Values(TunnelOptions::Via::kUdp, TunnelOptions::Via::kTcp));

TEST_F(GuardedTunnel, AnInterfaceThatDoesNotSayWhatItCarriesIsUsedAfterHalfASecond) {
  server->max_apdu.reset();
  connect();
  send(1, value(0x0a07));
  time.run_for(300ms);
  EXPECT_THAT(server->heard(), IsEmpty());
  time.run_for(300ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(count("unknown-services"), 0U);
}

TEST_F(GuardedTunnel, AnInterfaceThatSaysNonsenseIsUsed) {
  server->max_apdu = 0;
  connect();
  send(1, value(0x0a07));
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
}

TEST_F(GuardedTunnel, OtherGroupsStayPlain) {
  connect();
  send(1, value(0x1001));
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(server->heard().at(0).tpdu, (Bytes{0x00, 0x80, 0x0c, 0x33}));
}

TEST_F(GuardedTunnel, ATelegramThatIsRepeatedAfterAReconnectHasANewSequence) {
  connect();
  server->acks = server->confirms = false;
  send(1, value(0x0a07));
  time.run_for(2100ms);
  ASSERT_THAT(failures, SizeIs(1));
  ASSERT_THAT(server->heard(), SizeIs(1)) << "the repetition on the same tunnel is the same request";
  server->acks = server->confirms = true;
  time.run_for(2s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  ASSERT_THAT(server->heard(), SizeIs(2));
  EXPECT_GT(sequence_of(server->heard()[1]), sequence_of(server->heard()[0]));
}

TEST_F(GuardedTunnel, ReceivedTelegramsAreDecryptedAndTheMonitorGetsThemAsTheyAre) {
  connect();
  const auto cemi = indication(kOther, 7, value(0x0a07));
  server->inject_cemi(cemi);
  time.run_for(100ms);
  ASSERT_THAT(received, SizeIs(1));
  EXPECT_EQ(received[0].payload.bytes, (Bytes{0x0c, 0x33}));
  EXPECT_EQ(received[0].source, kOther);
  EXPECT_THAT(frames, ElementsAre(std::pair(false, cemi)));
}

TEST_F(GuardedTunnel, PlainAndReplayedTelegramsAreDroppedCountedAndNoted) {
  connect();
  server->inject(0x110b, 0x0a07, 0x80, {0x0c, 0x33});
  const auto cemi = indication(kOther, 7, value(0x0a07));
  server->inject_cemi(cemi);
  server->inject_cemi(cemi);
  time.run_for(100ms);
  EXPECT_THAT(received, SizeIs(1));
  EXPECT_EQ(count("data-secure-plain-dropped"), 1U);
  EXPECT_EQ(count("data-secure-old"), 1U);
  EXPECT_EQ(count("telegrams-received"), 1U);
  EXPECT_EQ(count("other-frames"), 0U);
  ASSERT_THAT(notes, SizeIs(2));
  EXPECT_EQ(notes[0].first, "data-secure-plain-dropped");
  EXPECT_THAT(notes[0].second, HasSubstr("plain telegram from 1.1.11 to 1/2/7"));
  EXPECT_EQ(notes[1].first, "data-secure-old");
}

TEST_F(GuardedTunnel, WithoutStorageOrKeyNothingIsSentAndTheReasonIsGiven) {
  auto keys = secure::one_group();
  keys.groups[wire::GroupAddress(0x1001)] = {};
  options.guard = &bench.start(keys, secure::GroupStorage{});
  connect();
  send(1, value(0x0a07));
  send(2, value(0x1001));
  send(3, value(0x1002));
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kRefused);
  EXPECT_THAT(outcomes[1].why, HasSubstr("no state file"));
  EXPECT_EQ(sent(2), SendOutcome::kRefused);
  EXPECT_THAT(outcomes[2].why, HasSubstr("2/0/1 is secured, and its key is not known"));
  EXPECT_EQ(sent(3), SendOutcome::kSent) << "others are not held up";
  EXPECT_THAT(server->heard(), SizeIs(1));
}

TEST_F(GuardedTunnel, NothingSecuredLeavesPlainThroughLossAndReconnects) {
  options.limits.rate = 0;
  server->set_weather({0.03, 0.03, 0.03, 5ms, 7});
  make_line();
  ASSERT_TRUE(line->open());
  for (std::uint16_t i = 1; i <= 200; ++i) send(i, value(0x0a07, {0, static_cast<std::uint8_t>(i)}), 10min);
  time.run_for(10min);
  GuardBench receiver;
  auto keys = secure::one_group();
  for (std::uint16_t device = 0xc8; device < 0xff; ++device)
    keys.groups[kSecuredGroup].senders.insert(wire::IndividualAddress(static_cast<std::uint16_t>(0x1100 + device)));
  receiver.start(keys, kOther);
  std::map<std::uint8_t, int> arrived;
  for (const auto& heard : server->heard()) {
    const auto telegram = secure::opened(*receiver.guard, heard.cemi);
    ASSERT_TRUE(telegram) << "no sequence number twice, none that goes back: " << telegram.error().why;
    ++arrived[telegram->payload.bytes[1]];
  }
  EXPECT_THAT(arrived, SizeIs(200));
  for (std::uint16_t i = 1; i <= 200; ++i)
    EXPECT_TRUE(sent(i) == SendOutcome::kSent || sent(i) == SendOutcome::kUnconfirmed) << i << ": " << outcomes[i].why;
}

/// A routing line with a guard of 1/2/7.
class GuardedRouter : public RoutingOverMemory {
 protected:
  RoutingOptions guarded() {
    RoutingOptions with;
    with.guard = &bench.start(secure::one_group(), with.address);
    return with;
  }
  void from_bus(const Bytes& cemi) {
    from_other(base::to_hex(wire::write(wire::Message(wire::RoutingIndication{cemi}))));
  }
  GuardBench bench;
};

TEST_F(GuardedRouter, TelegramsAreEncryptedAndDecrypted) {
  Router router(time, here, guarded());
  open(router);
  router.send(write_to(0x0a07));
  time.run_for(1ms);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kSent));
  ASSERT_THAT(other.received, SizeIs(1));
  EXPECT_THAT(other.received[0].second, HasSubstr("29003ce0fffa0a071003f110"));
  from_bus(indication(kOther, 7, write_to(0x0a07)));
  ASSERT_THAT(router.received, SizeIs(1));
  EXPECT_EQ(router.received[0].payload.bytes, (Bytes{0x0c, 0x33}));
}

TEST_F(GuardedRouter, PlainAndReplayedTelegramsAreDroppedCountedAndNoted) {
  Router router(time, here, guarded());
  open(router);
  from_other("0610053000132900bce0110b0a070300800c33");
  const auto cemi = indication(kOther, 7, write_to(0x0a07));
  from_bus(cemi);
  from_bus(cemi);
  EXPECT_THAT(router.received, SizeIs(1));
  const auto counters = router.line->counters();
  EXPECT_EQ(counters.at("data-secure-plain-dropped"), 1U);
  EXPECT_EQ(counters.at("data-secure-old"), 1U);
  EXPECT_EQ(counters.at("telegrams-received"), 1U);
  ASSERT_THAT(router.notes, SizeIs(2));
  EXPECT_THAT(router.notes[0].second, HasSubstr("routed a plain telegram from 1.1.11 to 1/2/7"));
}

TEST_F(GuardedRouter, WithoutStorageNothingIsSent) {
  RoutingOptions with;
  with.guard = &bench.start(secure::one_group(), secure::GroupStorage{});
  Router router(time, here, with);
  open(router);
  router.send(write_to(0x0a07));
  time.run_for(1s);
  EXPECT_THAT(router.outcomes, ElementsAre(SendOutcome::kRefused));
  EXPECT_THAT(other.received, IsEmpty());
}

}  // namespace
}  // namespace rubicon::networks::knx::line
