#include <gmock/gmock.h>

#include "motes/mote_vectors.h"
#include "networks/wsn/sink/sink_fixture.h"

namespace rubicon::networks::wsn::sink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using SerialSinkTest = SerialSinkFixture;

TEST_F(SerialSinkTest, GreetsWithTheOriginalsBytes) {
  make(0x0e);
  open();
  EXPECT_EQ(phase(), Phase::kConnecting);
  time.run_for(20ms);
  EXPECT_EQ(base::to_hex(mote.raw), "7e440e00000100000300250a002acaa37e");
  EXPECT_EQ(phase(), Phase::kConnecting) << "nothing was heard yet";
  time.run_for(100ms);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(states.size(), 1U);
  EXPECT_THAT(left, ElementsAre(set_island(42)));
}

TEST_F(SerialSinkTest, EscapesAsTheOriginalDoes) {
  options.greeting = set_island(0x7d7e);
  make(0x7e);
  open();
  time.run_for(20ms);
  EXPECT_EQ(base::to_hex(mote.raw), "7e447d5e00000100000300250a7d5d7d5e0e437e");
}

/// Every frame from the computer to a sink among the vectors, sent by us with the sequence number it has there.
TEST_F(SerialSinkTest, SendsTheVectorsByteForByte) {
  std::size_t sent = 0;
  for (const auto& vector : motes::shared_vectors()) {
    if (vector.kind != "hdlc" || vector.bytes.size() < 4 || vector.bytes[1] != motes::kHdlcAckedPacket) continue;
    motes::HdlcReader reader;
    ByteView bytes(vector.bytes);
    const auto frame = reader.next(bytes);
    ASSERT_TRUE(frame) << vector.name;
    if (frame->packet.empty() || frame->packet[0] != 0) continue;
    options.greeting.assign(frame->packet.begin(), frame->packet.end());
    mote.raw.clear();
    make(frame->sequence);
    open();
    time.run_for(20ms);
    EXPECT_EQ(base::to_hex(mote.raw), base::to_hex(vector.bytes)) << vector.name;
    sink.reset();
    time.run_for(1s);
    ++sent;
  }
  if (sent == 0) GTEST_SKIP() << "no ../shared/data/motes/vectors.tsv beside the source tree";
  EXPECT_GT(sent, 30U);
}

/// wsn.md 15: what the original sent as the first to 25th retry of island 42.
TEST_F(SerialSinkTest, RepeatsUnderANewSequenceNumberEachTime) {
  mote.answers = false;
  make(0x0e);
  open();
  time.run_for(2500ms);
  EXPECT_EQ(base::to_hex(mote.raw),
            "7e440e00000100000300250a002acaa37e"
            "7e440f00000100000300250a002abfa07e"
            "7e441000000100000300250a002a0c847e");
  ASSERT_EQ(mote.heard.size(), 3U);
  EXPECT_EQ(mote.heard[1].when - mote.heard[0].when, 1s);
  EXPECT_EQ(count("repeated-frames"), 2U);
  EXPECT_EQ(left.size(), 1U) << "repetitions are not reported";
}

TEST_F(SerialSinkTest, IsALostLineWhereTheSinkAnswersNothing) {
  mote.answers = false;
  reopens = false;
  make();
  open();
  time.run_for(2999ms);
  EXPECT_THAT(failures, IsEmpty());
  time.run_for(10ms);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(failures[0].code, ErrorCode::kUnreachable);
  EXPECT_THAT(failures[0].text, HasSubstr("network@10.0.0.9:19202: the sink does not acknowledge"));
  EXPECT_EQ(phase(), Phase::kOff);
  time.run_for(1s);
  EXPECT_FALSE(mote.connected());
}

TEST_F(SerialSinkTest, HintsAtTheBaudRateWhereOnlyGarbageComes) {
  mote.answers = false;
  reopens = false;
  make();
  open();
  time.run_for(100ms);
  mote.say_raw(hex("80f8003cff0080f8"));
  time.run_for(5s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, HasSubstr("baud rate"));
  EXPECT_EQ(count("garbage-bytes"), 8U);
}

TEST_F(SerialSinkTest, StaysUpWithAReasonWherePacketsComeAndAcksDoNot) {
  mote.answers = false;
  make();
  open();
  time.run_for(100ms);
  mote.say(numbered(1));
  time.run_for(1ms);
  EXPECT_EQ(phase(), Phase::kUp) << "the first valid frame";
  time.run_for(5s);
  EXPECT_THAT(failures, IsEmpty());
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(sink->state().reason, "the sink does not acknowledge");
  ASSERT_EQ(states.size(), 2U);
  ASSERT_TRUE(send(7));
  time.run_for(4s);
  EXPECT_EQ(outcome(7), SendResult::kNotAcknowledged);
  mote.answers = true;
  ASSERT_TRUE(send(8));
  time.run_for(4s);
  EXPECT_EQ(outcome(8), SendResult::kAcknowledged);
  EXPECT_EQ(sink->state().reason, "");
}

TEST_F(SerialSinkTest, IsUpAtOnceWithoutAGreeting) {
  options.greeting.clear();
  make();
  open();
  time.run_for(10ms);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_THAT(mote.raw, IsEmpty());
}

TEST_F(SerialSinkTest, SendsACommandInTheNextTurn) {
  connect();
  ASSERT_TRUE(send(1));
  EXPECT_THAT(left, ElementsAre(set_island(42))) << "never from inside a call";
  time.run_ready();
  EXPECT_THAT(left, ElementsAre(set_island(42), numbered(1)));
  time.run_for(net.tcp.transit);
  EXPECT_EQ(mote.heard.size(), 1U);
}

TEST_F(SerialSinkTest, PutsBothFlagsAroundEachFrame) {
  connect(0x20);
  for (std::uint16_t i = 0; i < 3; ++i) ASSERT_TRUE(send(i));
  time.run_for(1s);
  Bytes wanted;
  for (std::uint8_t i = 0; i < 3; ++i) {
    const auto frame = motes::hdlc_acked_packet(static_cast<std::uint8_t>(0x21 + i), numbered(i));
    EXPECT_EQ(frame.front(), 0x7e);
    EXPECT_EQ(frame.back(), 0x7e);
    wanted.insert(wanted.end(), frame.begin(), frame.end());
  }
  EXPECT_EQ(base::to_hex(mote.raw), base::to_hex(wanted));
}

TEST_F(SerialSinkTest, CountsSequenceNumbersOnBeyond255) {
  connect(0xfd);
  for (std::uint16_t i = 0; i < 4; ++i) ASSERT_TRUE(send(i));
  time.run_for(1s);
  ASSERT_EQ(mote.heard.size(), 4U);
  EXPECT_EQ(mote.heard[0].sequence, 0xfe);
  EXPECT_EQ(mote.heard[1].sequence, 0xff);
  EXPECT_EQ(mote.heard[2].sequence, 0x00);
  EXPECT_EQ(mote.heard[3].sequence, 0x01);
  EXPECT_EQ(results.size(), 4U);
}

TEST_F(SerialSinkTest, PacesTenCommandsForASinkThatLosesWhatComesTooSoon) {
  connect();
  for (std::uint16_t i = 0; i < 10; ++i) ASSERT_TRUE(send(i));
  time.run_for(2s);
  EXPECT_THAT(executed(), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(count("acknowledged"), 11U);
  EXPECT_EQ(count("packets-written"), 11U);
  EXPECT_EQ(count("repeated-frames"), 0U);
  for (std::uint16_t i = 0; i < 10; ++i) EXPECT_EQ(outcome(i), SendResult::kAcknowledged);
}

TEST_F(SerialSinkTest, PushesBackOnAThousandCommandsAndLosesNone) {
  connect();
  std::uint16_t next = 0;
  const auto push = [&] {
    while (next < 1000 && send(next, {Lane::kClient})) ++next;
  };
  on_room = push;
  push();
  EXPECT_EQ(next, options.lane_size);
  EXPECT_EQ(send(next, {Lane::kClient}).error().code, ErrorCode::kBusy);
  EXPECT_EQ(count("waiting-client"), options.lane_size);
  time.run_for(100s);
  EXPECT_EQ(mote.executed.size(), 1000U);
  EXPECT_EQ(results.size(), 1000U);
  EXPECT_EQ(number_in(mote.executed.back()), 999);
}

TEST_F(SerialSinkTest, WaitsForAnAckThatTakes113Milliseconds) {
  connect();
  mote.ack_delay = 113ms;
  ASSERT_TRUE(send(1));
  ASSERT_TRUE(send(2));
  time.run_for(1s);
  EXPECT_THAT(executed(), ElementsAre(1, 2));
  EXPECT_EQ(count("repeated-frames"), 0U);
}

TEST_F(SerialSinkTest, WaitsOverAnAckOfAnotherNumber) {
  connect(0x10);
  mote.instead = [&](const auto& heard) { mote.ack(static_cast<std::uint8_t>(heard.sequence + 5)); };
  ASSERT_TRUE(send(1));
  time.run_for(900ms);
  EXPECT_FALSE(outcome(1));
  EXPECT_EQ(mote.heard.size(), 1U);
  mote.ack(0x10);
  time.run_for(50ms);
  EXPECT_FALSE(outcome(1)) << "the greeting's";
  mote.ack(0x11);
  time.run_for(10ms);
  EXPECT_EQ(outcome(1), SendResult::kAcknowledged);
}

TEST_F(SerialSinkTest, GivesUpAfterThreeAttempts) {
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1));
  time.run_for(2999ms);
  EXPECT_FALSE(outcome(1));
  time.run_for(10ms);
  EXPECT_EQ(outcome(1), SendResult::kNotAcknowledged);
  EXPECT_EQ(mote.heard.size(), 3U);
  EXPECT_EQ(count("unacknowledged"), 1U);
  EXPECT_TRUE(noted("unacknowledged"));
  EXPECT_EQ(sink->state().reason, "the sink does not acknowledge");
}

TEST_F(SerialSinkTest, SendsOnlyOnceWhatMayNotBeRepeated) {
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1, {Lane::kClient, 24h, false}));
  time.run_for(10s);
  EXPECT_EQ(mote.heard.size(), 1U);
  EXPECT_EQ(outcome(1), SendResult::kNotAcknowledged);
}

TEST_F(SerialSinkTest, RepeatsNothingWhoseTimeIsOver) {
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1, {Lane::kCommand, 1500ms}));
  time.run_for(10s);
  EXPECT_EQ(mote.heard.size(), 2U);
  EXPECT_EQ(outcome(1), SendResult::kNotAcknowledged) << "it may have been executed";
}

TEST_F(SerialSinkTest, TakesTheAckOfAnEarlierAttemptButLetsTheLastOneArrive) {
  connect(0x10);
  mote.ack_delay = 1050ms;
  ASSERT_TRUE(send(1));
  ASSERT_TRUE(send(2));
  time.run_for(900ms);
  mote.ack_delay = 200ms;
  time.run_for(160ms);
  EXPECT_EQ(outcome(1), SendResult::kAcknowledged);
  EXPECT_EQ(mote.heard.size(), 2U) << "the next packet waits: the sink would lose it";
  time.run_for(3s);
  EXPECT_EQ(executed().back(), 2);
  EXPECT_EQ(outcome(2), SendResult::kAcknowledged);
  EXPECT_EQ(count("acknowledged"), 3U);
}

TEST_F(SerialSinkTest, GoesOnWhereTheLastAttemptIsNeverAcked) {
  connect(0x10);
  mote.instead = [&](const auto& heard) {
    if (heard.sequence == 0x12) mote.ack(0x11);
    if (heard.sequence > 0x12) mote.ack(heard.sequence);
  };
  ASSERT_TRUE(send(1));
  ASSERT_TRUE(send(2));
  time.run_for(1500ms);
  EXPECT_EQ(outcome(1), SendResult::kAcknowledged);
  EXPECT_FALSE(outcome(2));
  time.run_for(1s);
  EXPECT_EQ(outcome(2), SendResult::kAcknowledged);
}

TEST_F(SerialSinkTest, ExpiresWhatCouldNotLeaveInTime) {
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1));
  ASSERT_TRUE(send(2, {Lane::kCommand, 2s}));
  time.run_for(2s);
  EXPECT_EQ(outcome(2), SendResult::kExpired);
  time.run_for(5s);
  EXPECT_EQ(mote.heard.size(), 3U);
  EXPECT_EQ(count("expired"), 1U);
}

TEST_F(SerialSinkTest, AcksASinksPacketBeforeItIsDelivered) {
  connect();
  on_received = [&] { sink.reset(); };
  mote.say_raw(motes::hdlc_acked_packet(0x63, numbered(5)));
  time.run_for(10ms);
  EXPECT_EQ(sink, nullptr);
  EXPECT_THAT(mote.acks, ElementsAre(0x63));
}

TEST_F(SerialSinkTest, AcksASinksPacketAtOnceThoughOneOfOursIsUnderWay) {
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1));
  time.run_for(10ms);
  mote.raw.clear();
  on_received = [&] { ASSERT_TRUE(send(2)); };
  mote.say_raw(motes::hdlc_acked_packet(0x63, numbered(5)));
  time.run_for(10ms);
  EXPECT_EQ(base::to_hex(mote.raw), "7e43635a047e");
  EXPECT_THAT(received, ElementsAre(numbered(5)));
}

TEST_F(SerialSinkTest, MayBeDestroyedInEachOfItsCalls) {
  for (int call = 0; call < 4; ++call) {
    on_received = on_left = on_room = nullptr;
    mote.heard.clear();
    connect();
    const auto end = [&] { sink.reset(); };
    if (call == 0) on_received = end;
    if (call == 1) on_left = end;
    if (call == 2) on_room = end;
    if (call < 3) {
      for (std::size_t i = 0; i < options.lane_size; ++i)
        ASSERT_TRUE(send(static_cast<std::uint16_t>(static_cast<std::size_t>(call) * 1000 + i)));
      EXPECT_FALSE(send(9999));
    } else {
      Outgoing packet;
      packet.packet = numbered(1);
      packet.done = [&](SendResult) { sink.reset(); };
      ASSERT_TRUE(sink->send(std::move(packet)));
    }
    Bytes two = motes::hdlc_packet(numbered(5));
    const auto again = two;
    two.insert(two.end(), again.begin(), again.end());
    mote.say_raw(two);
    time.run_for(1s);
    EXPECT_EQ(sink, nullptr) << call;
    time.run_for(1s);
  }
}

// A lost line.

TEST_F(SerialSinkTest, SendsWhatALostLineInterruptedFirstAfterTheGreeting) {
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1, {Lane::kProbe}));
  ASSERT_TRUE(send(2));
  time.run_for(10ms);
  mote.hang_up();
  time.run_for(10ms);
  ASSERT_EQ(failures.size(), 1U);
  mote.answers = true;
  ASSERT_TRUE(send(3));
  time.run_for(2s);
  EXPECT_THAT(mote.executed, ElementsAre(numbered(2), set_island(42), numbered(2), numbered(3), numbered(1)));
  EXPECT_THAT(left, ElementsAre(set_island(42), numbered(2), set_island(42), numbered(3), numbered(1)));
}

TEST_F(SerialSinkTest, KeepsWhatWaitsWhileThereIsNoLine) {
  reopens = false;
  connect();
  mote.hang_up();
  time.run_for(10ms);
  EXPECT_EQ(phase(), Phase::kOff);
  ASSERT_TRUE(send(1));
  ASSERT_TRUE(send(2, {Lane::kCommand, 1s}));
  time.run_for(1h);
  EXPECT_EQ(outcome(2), SendResult::kExpired);
  EXPECT_FALSE(outcome(1));
  open();
  time.run_for(1s);
  EXPECT_THAT(mote.executed, ElementsAre(set_island(42), numbered(1)));
}

TEST_F(SerialSinkTest, DoesNotRepeatOnANewLineWhatMayNotBeRepeated) {
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1, {Lane::kClient, 24h, false}));
  time.run_for(10ms);
  mote.hang_up();
  mote.answers = true;
  time.run_for(5s);
  EXPECT_EQ(outcome(1), SendResult::kNotAcknowledged);
  EXPECT_EQ(mote.heard.size(), 2U) << "itself, and the second greeting";
}

TEST_F(SerialSinkTest, DoesNotSendAnExpiredCommandLater) {
  reopens = false;
  connect();
  mote.answers = false;
  ASSERT_TRUE(send(1, {Lane::kCommand, 5s}));
  time.run_for(10ms);
  mote.hang_up();
  time.run_for(4s);
  EXPECT_FALSE(outcome(1));
  time.run_for(1s);
  EXPECT_EQ(outcome(1), SendResult::kNotAcknowledged);
  mote.answers = true;
  open();
  time.run_for(5s);
  EXPECT_EQ(mote.heard.size(), 2U);
}

TEST_F(SerialSinkTest, RepeatsOnOneNewLineOnly) {
  connect();
  mote.instead = [&](const auto& heard) {
    if (heard.packet == set_island(42)) return mote.ack(heard.sequence);
    mote.hang_up();
  };
  ASSERT_TRUE(send(1));
  time.run_for(10s);
  EXPECT_EQ(outcome(1), SendResult::kNotAcknowledged);
  EXPECT_EQ(failures.size(), 2U);
}

TEST_F(SerialSinkTest, BeginsAfreshInTheMiddleOfAFrame) {
  connect();
  mote.say_raw(hex("7e4500ffff0000"));
  time.run_for(10ms);
  mote.hang_up();
  time.run_for(1s);
  mote.say(numbered(5));
  time.run_for(10ms);
  EXPECT_THAT(received, ElementsAre(numbered(5)));
  EXPECT_EQ(count("bad-crc"), 0U);
}

TEST_F(SerialSinkTest, GivesUpALineThatTakesNoBytes) {
  connect();
  net.tcp.stall(true);
  ASSERT_TRUE(send(1));
  time.run_for(2900ms);
  EXPECT_THAT(failures, IsEmpty());
  time.run_for(200ms);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, HasSubstr("the line takes no bytes"));
  EXPECT_EQ(count("repeated-frames"), 0U) << "nothing piles up";
  net.tcp.stall(false);
  time.run_for(5s);
  EXPECT_EQ(outcome(1), SendResult::kAcknowledged);
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
