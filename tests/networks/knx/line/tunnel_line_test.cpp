#include "networks/knx/line/line_fixture.h"

namespace rubicon::networks::knx::line {
namespace {

using Phase = LineState::Phase;

class TunnelLineTest : public LineFixture {};

TEST_F(TunnelLineTest, ComesUpAndKnowsItsAddressAndServer) {
  net.name("knx.home", {"fe80::1", "10.0.0.9"});
  options.host = "knx.home";
  connect();
  EXPECT_EQ(line->state().own, wire::IndividualAddress{0x11c8});
  EXPECT_EQ(line->state().server, "knx.home (10.0.0.9:3671)");
  EXPECT_TRUE(line->state().bus);
  ASSERT_EQ(states.size(), 2U);
  EXPECT_EQ(states[0].phase, Phase::kConnecting);
  EXPECT_EQ(server->counters.connects, 1U);
}

TEST_F(TunnelLineTest, AWriteReachesTheBusAndIsReportedSent) {
  connect();
  send(1);
  EXPECT_TRUE(outcomes.empty());
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  ASSERT_EQ(server->heard().size(), 1U);
  EXPECT_EQ(base::to_hex(server->heard()[0].cemi), "1100bce000000a070300800001");
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_TRUE(frames[0].first);
  EXPECT_EQ(frames[1].second[0], 0x2e);
  EXPECT_TRUE(received.empty());
  EXPECT_EQ(count("telegrams-sent"), 1U);
}

TEST_F(TunnelLineTest, ReceivesTelegramsOfAnySource) {
  connect();
  server->inject(0x11c8, 0x0a03, 0x80, {1}, true);  // its own address: installations double them
  server->inject(0x1101, 0x0a08, 0x40, {0x0c, 0x65});
  server->inject_read(0x1101, 0x0a05);
  server->inject_cemi({0x29, 0, 0xbc, 0x60, 0x11, 1, 0x11, 2, 0, 0x80});  // a connection between devices
  server->inject_cemi({0x2b, 3, 1, 0xbc});
  server->inject_cemi({0x29, 0, 0x3c, 0xe4, 0x11, 1, 0x11, 2, 1, 0, 0x80});
  server->inject_cemi({0x29, 0, 0xbc});
  time.run_for(1s);
  ASSERT_EQ(received.size(), 3U);
  EXPECT_EQ(received[0].payload, (wire::Payload{{1}, true}));
  EXPECT_EQ(received[1].service, wire::Service::kResponse);
  EXPECT_EQ(received[2].service, wire::Service::kRead);
  EXPECT_EQ(frames.size(), 7U);
  EXPECT_EQ(server->counters.acks, 7U) << "everything in sequence is acknowledged";
  EXPECT_EQ(count("other-frames"), 1U);
  EXPECT_EQ(count("lte-frames"), 1U);
  EXPECT_EQ(count("doubled-address"), 1U);
  EXPECT_EQ(count("bad-frames"), 1U);
}

TEST_F(TunnelLineTest, AReadIsAnswered) {
  connect();
  server->answers[0x0a05] = {{1}, true};
  wire::Telegram read;
  read.service = wire::Service::kRead;
  read.destination = wire::GroupAddress{0x0a05};
  send(1, read);
  time.run_for(1s);
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0].service, wire::Service::kResponse);
}

TEST_F(TunnelLineTest, LongValuesGoAsExtendedFrames) {
  connect();
  send(1, write(0x0a09, Bytes(20, 0x41)));
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(server->heard().at(0).tpdu.size(), 22U);
  send(2, write(0x0a09, Bytes(254, 0x41)));
  time.run_for(1s);
  EXPECT_EQ(sent(2), SendOutcome::kRefused);
  EXPECT_NE(outcomes[2].why.find("254 bytes"), std::string::npos);
}

TEST_F(TunnelLineTest, SequencesRunThroughTheirWrapBothWays) {
  connect();
  for (std::uint16_t i = 0; i < 600; ++i) {
    send(i);
    server->inject(0x1101, 0x0a08, 0x80, {1, 2});
  }
  time.run_for(10s);
  EXPECT_EQ(order.size(), 600U);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  EXPECT_EQ(received.size(), 600U);
  EXPECT_EQ(count("telegrams-sent"), 600U);
  EXPECT_EQ(count("repeats"), 0U);
}

TEST_F(TunnelLineTest, AConfirmationBeforeTheAckIsRemembered) {
  connect();
  server->ack_time = 50ms;
  send(1);
  send(2);
  time.run_for(45ms);
  EXPECT_TRUE(outcomes.empty());
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(sent(2), SendOutcome::kSent);
  EXPECT_EQ(count("repeats"), 0U);
  EXPECT_EQ(server->heard().size(), 2U);
}

TEST_F(TunnelLineTest, AConfirmationWithoutAnAckIsAnAck) {
  connect();
  server->acks = false;
  send(1);
  send(2);
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(sent(2), SendOutcome::kSent);
  EXPECT_EQ(count("repeats"), 0U);
  EXPECT_EQ(count("missing-acks"), 2U);
  EXPECT_EQ(server->counters.out_of_sequence, 0U);
}

TEST_F(TunnelLineTest, AMissingAckMakesOneRepeatWithTheSameSequence) {
  connect();
  server->listens = false;
  send(1);
  time.run_for(900ms);
  server->listens = true;
  time.run_for(50ms);
  EXPECT_TRUE(outcomes.empty());
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(count("repeats"), 1U);
  EXPECT_EQ(server->heard().size(), 1U);
  EXPECT_TRUE(failures.empty());
}

TEST_F(TunnelLineTest, ALateAckAfterTheRepetitionIsAccepted) {
  connect();
  server->ack_time = 1200ms;
  server->confirm_time = 1300ms;
  send(1);
  time.run_for(3s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(server->heard().size(), 1U);
  EXPECT_EQ(server->counters.repeats_seen, 1U);
}

TEST_F(TunnelLineTest, WithoutAcksTheLineIsLostAndTheTelegramSentOnceMore) {
  connect();
  server->acks = server->confirms = false;
  send(1);
  send(2);
  time.run_for(2100ms);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("does not acknowledge"), std::string::npos);
  EXPECT_EQ(server->counters.disconnects, 1U);
  EXPECT_TRUE(outcomes.empty());
  server->acks = server->confirms = true;
  time.run_for(2s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(sent(2), SendOutcome::kSent);
  EXPECT_EQ(order.front(), 1);
  EXPECT_EQ(count("reconnects"), 1U);
}

TEST_F(TunnelLineTest, ATelegramThatIsLostTwiceIsReportedOnce) {
  connect();
  server->acks = server->confirms = false;
  send(1);
  time.run_for(10s);
  EXPECT_EQ(sent(1), SendOutcome::kLost);
  EXPECT_EQ(failures.size(), 2U);
  EXPECT_EQ(count("telegrams-lost"), 1U);
}

TEST_F(TunnelLineTest, AnExpiredTelegramIsNotSentAgain) {
  connect();
  reopen_pause = 5s;
  server->acks = server->confirms = false;
  send(1, 3s);
  send(2, 4s);
  send(3, 60s);
  time.run_for(6s);
  EXPECT_EQ(sent(1), SendOutcome::kLost);
  EXPECT_EQ(sent(2), SendOutcome::kExpired);
  EXPECT_FALSE(outcomes.contains(3));
  server->acks = server->confirms = true;
  time.run_for(5s);
  EXPECT_EQ(sent(3), SendOutcome::kSent);
}

TEST_F(TunnelLineTest, ATelegramTheServerDoesNotUnderstandIsRefusedAndTheTunnelStays) {
  connect();
  server->ack_status = 0x29;
  send(1);
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kRefused);
  server->ack_status = 0;
  send(2);
  time.run_for(100ms);
  EXPECT_EQ(sent(2), SendOutcome::kSent);
  EXPECT_TRUE(failures.empty());
}

TEST_F(TunnelLineTest, AnErrorInTheAckIsAMissingAck) {
  connect();
  server->ack_status = 0x0f;
  send(1);
  time.run_for(20ms);
  EXPECT_EQ(failures.size(), 1U);
  server->ack_status = 0;
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
}

TEST_F(TunnelLineTest, ANegativeConfirmationIsReportedAndTheTunnelStays) {
  connect();
  server->confirms_negatively = true;
  send(1);
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kNotAcknowledged);
  EXPECT_EQ(count("not-acknowledged"), 1U);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(TunnelLineTest, ThreeTelegramsWithoutConfirmationMakeTheBusSilent) {
  connect();
  server->confirms = false;
  for (std::uint16_t i = 1; i <= 3; ++i) send(i);
  time.run_for(8s);
  EXPECT_TRUE(line->state().bus);
  time.run_for(2s);
  for (std::uint16_t i = 1; i <= 3; ++i) EXPECT_EQ(sent(i), SendOutcome::kUnconfirmed);
  EXPECT_FALSE(line->state().bus);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_NE(line->state().reason.find("silent"), std::string::npos);
  server->confirms = true;
  send(4);
  time.run_for(1s);
  EXPECT_TRUE(line->state().bus);
  EXPECT_TRUE(line->state().reason.empty());
}

TEST_F(TunnelLineTest, ALateConfirmationConfirmsNothingElse) {
  connect();
  server->confirm_time = 3500ms;
  send(1);
  send(2);
  time.run_for(3900ms);
  EXPECT_EQ(sent(1), SendOutcome::kUnconfirmed);
  EXPECT_FALSE(outcomes.contains(2));
  EXPECT_EQ(count("late-confirmations"), 1U);
}

TEST_F(TunnelLineTest, ALateConfirmationDoesNotConfirmAnEqualTelegram) {
  connect();
  const auto equal = write(0x0a07, {1}, true);
  server->confirm_time = 3100ms;  // of the first one: it comes while the second one is under way
  send(1, equal);
  time.run_for(3050ms);
  EXPECT_EQ(sent(1), SendOutcome::kUnconfirmed);
  server->confirm_time = 500ms;
  server->confirms_negatively = true;
  send(2, equal);
  time.run_for(300ms);
  EXPECT_FALSE(outcomes.contains(2)) << "that was the confirmation of the first";
  time.run_for(1s);
  EXPECT_EQ(sent(2), SendOutcome::kNotAcknowledged);
  EXPECT_EQ(count("late-confirmations"), 1U);
}

TEST_F(TunnelLineTest, AMissingConfirmationAffectsOneEqualTelegramAtMost) {
  connect();
  const auto equal = write(0x0a07, {1}, true);
  server->confirms = false;
  send(1, equal);
  time.run_for(3100ms);
  EXPECT_EQ(sent(1), SendOutcome::kUnconfirmed);
  server->confirms = true;
  send(2, equal);
  time.run_for(3100ms);
  EXPECT_EQ(sent(2), SendOutcome::kUnconfirmed) << "the one confirmation could belong to either";
  send(3, equal);
  send(4, equal);
  time.run_for(100ms);
  EXPECT_EQ(sent(3), SendOutcome::kSent);
  EXPECT_EQ(sent(4), SendOutcome::kSent);
  server->confirms = false;
  send(5, equal);
  time.run_for(8100ms);
  server->confirms = true;
  send(6, equal);
  time.run_for(100ms);
  EXPECT_EQ(sent(6), SendOutcome::kSent) << "after some seconds none is waited for";
}

TEST_F(TunnelLineTest, WhatWasUnderWayAtTheEndOfATunnelIsCounted) {
  connect();
  server->ack_time = 50ms;  // the confirmation comes first
  send(1);
  time.run_for(20ms);
  server->disconnect_all();
  time.run_for(10ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(count("telegrams-sent"), 1U);
  time.run_for(1s);
  server->ack_time = {};
  server->confirms = false;
  send(2);
  time.run_for(20ms);
  server->disconnect_all();
  time.run_for(10ms);
  EXPECT_EQ(sent(2), SendOutcome::kUnconfirmed);
  EXPECT_EQ(count("unconfirmed"), 1U);
}

TEST_F(TunnelLineTest, ALostDisconnectRequestCostsTheServerNoTunnel) {
  connect();
  int sent_ones = 0;
  net.loses = [&](const transport::MemoryDatagram& datagram) {
    return datagram.bytes.size() > 3 && datagram.bytes[3] == 0x09 && datagram.to.port == 3671 && ++sent_ones == 1;
  };
  line.reset();
  time.run_for(100ms);
  EXPECT_TRUE(server->channels().empty());
  net.loses = nullptr;
}

TEST_F(TunnelLineTest, AFrameReceivedTwiceIsAcknowledgedTwiceAndReportedOnce) {
  connect();
  server->inject(0x1101, 0x0a08, 0x80, {1, 2});
  time.run_for(100ms);
  server->skip_sequence(static_cast<std::uint8_t>(-1));
  server->inject(0x1101, 0x0a08, 0x80, {1, 2});
  time.run_for(100ms);
  EXPECT_EQ(received.size(), 1U);
  EXPECT_EQ(server->counters.acks, 2U);
  EXPECT_EQ(count("duplicates"), 1U);
}

TEST_F(TunnelLineTest, AWrongSequenceIsNotAcknowledgedAndEndsTheTunnelAfterTwoSeconds) {
  connect();
  server->skip_sequence(3);
  server->inject(0x1101, 0x0a08, 0x80, {1, 2});
  time.run_for(1900ms);
  EXPECT_EQ(server->counters.acks, 0U);
  EXPECT_TRUE(failures.empty());
  EXPECT_EQ(count("wrong-sequence"), 2U);
  time.run_for(200ms);
  EXPECT_EQ(failures.size(), 1U);
  EXPECT_EQ(server->counters.disconnects, 1U);
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(TunnelLineTest, AGoodFrameStopsTheResynchronisation) {
  connect();
  server->skip_sequence(3);
  server->inject(0x1101, 0x0a08, 0x80, {1, 2});
  time.run_for(500ms);
  server->skip_sequence(static_cast<std::uint8_t>(-3));
  time.run_for(5s);
  EXPECT_TRUE(failures.empty());
  EXPECT_EQ(received.size(), 1U);
}

TEST_F(TunnelLineTest, FramesOfOtherChannelsAreNotAcknowledged) {
  connect();
  server->send_raw(*base::from_hex("061004200015046300002900bce011010a05010041"));
  server->send_raw(*base::from_hex("06100421000a04630000"));
  server->send_raw(*base::from_hex("061002090010630008010000000000 00"));
  server->send_raw(*base::from_hex("0610020800086321"));
  time.run_for(100ms);
  EXPECT_TRUE(received.empty());
  EXPECT_EQ(server->counters.acks, 0U);
  EXPECT_EQ(count("wrong-channel"), 4U);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(TunnelLineTest, BadAndUnknownFramesAreCountedAndSurvived) {
  connect();
  for (const auto* hex : {"", "0610", "0610053800060000", "061004200015040100002900bce0", "06110420000a04010000",
                          "0610042000090401 00", "06100206000801"})
    server->send_raw(*base::from_hex(hex));
  server->send_raw(*base::from_hex("061005380006"));
  server->send_raw(*base::from_hex("06100950000800 00"));
  time.run_for(100ms);
  EXPECT_EQ(count("bad-frames"), 7U);
  EXPECT_EQ(count("unknown-services"), 2U);
  ASSERT_EQ(notes.size(), 9U);
  EXPECT_EQ(notes[0].first, "bad-frames");
  EXPECT_EQ(notes[7].first, "unknown-services");
  EXPECT_EQ(notes[7].second, "the interface sent service 0538: ignored");
  send(1);
  time.run_for(100ms);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
}

TEST_F(TunnelLineTest, DatagramsFromOtherAddressesAreDropped) {
  connect();
  transport::MemoryTransports stranger;
  stranger.join(net, "10.0.0.66");
  const auto socket = stranger.open_udp({}, {[](const auto&, ByteView) {}, [](const Error&) {}, [](const Error&) {}});
  const auto port = net.sent().front().from.port;
  (void)(*socket)->send({"10.0.0.2", port}, *base::from_hex("061002090010010008010000000000 00"));
  time.run_for(100ms);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(count("wrong-source"), 1U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].first, "wrong-source");
  EXPECT_NE(notes[0].second.find("10.0.0.66:"), std::string::npos);
}

TEST_F(TunnelLineTest, DestructionClosesTheTunnel) {
  connect();
  send(1);
  line.reset();
  time.run_for(100ms);
  EXPECT_TRUE(server->channels().empty());
  EXPECT_EQ(server->counters.disconnects, 2U) << "one may get lost";
  EXPECT_TRUE(outcomes.empty());
  EXPECT_EQ(net.open_sockets(), 1U);
}

TEST_F(TunnelLineTest, MayBeDestroyedInAnyOfItsCalls) {
  for (const int when : {0, 1, 2, 3, 4, 5, 6}) {
    connect();
    LineCallbacks calls;
    const auto destroy_if = [this, when](int now) {
      if (when == now) line.reset();
    };
    calls.changed = [=](const LineState& state) {
      destroy_if(state.phase == Phase::kConnecting ? 0 : state.phase == Phase::kUp ? 1 : -1);
    };
    calls.failed = [=](const Error&) { destroy_if(2); };
    calls.received = [=](const wire::Telegram&) { destroy_if(3); };
    calls.frame = [=](ByteView, bool outgoing) { destroy_if(outgoing ? 4 : 5); };
    calls.note = [=](const std::string&, std::string_view) { destroy_if(6); };
    line = std::make_unique<TunnelLine>(options, time, transports, std::move(calls));
    ASSERT_TRUE(line->open());
    time.run_for(100ms);
    if (line && when != 3) line->send(write(1, {1, 1}), SteadyTime::max(), [](SendOutcome, std::string_view) {});
    time.run_for(100ms);
    server->inject(0x1101, 0x0a08, 0x80, {1, 2});
    time.run_for(100ms);
    server->send_raw(*base::from_hex("061005380006"));
    time.run_for(100ms);
    server->disconnect_all();
    time.run_for(100ms);
    EXPECT_EQ(line, nullptr) << when;
  }
  connect();
  line->send(write(1, {1, 1}), SteadyTime::max(), [this](SendOutcome, std::string_view) { line.reset(); });
  time.run_for(1s);
  EXPECT_EQ(line, nullptr);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
