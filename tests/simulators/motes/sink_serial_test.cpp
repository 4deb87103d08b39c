#include <gmock/gmock.h>

#include "simulators/motes/simulated_sink.h"

namespace rubicon::motes_simulator {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const Bytes kProbe = base::from_hex("00").value();

/// wsn.md 10, row by row: what the original sink does with odd input.
class SinkSerial : public SimulatedSink {
 protected:
  void SetUp() override { joined(); }
  static Bytes probe(std::uint8_t serial, std::uint16_t sequence, std::uint16_t to = 1) {
    return motes::hdlc_acked_packet(serial, motes::packet_of(command(to, kProbe, sequence, 1)));
  }
  void settle() { time.run_for(500ms); }
};

TEST_F(SinkSerial, AcknowledgesASoundFrameAndAnswersAReliableMessage) {
  send(probe(0x26, 0x0106));
  settle();
  EXPECT_THAT(acks(), ElementsAre(0x26));
  EXPECT_THAT(acknowledged(1), ElementsAre(0x0106));
  EXPECT_EQ(packets(1).front().net().counted, 6) << "the sink writes the true length of its own messages";
}

TEST_F(SinkSerial, AcknowledgesUnknownDispatchBytesAndIgnoresThem) {
  auto packet = motes::packet_of(command(1, kProbe, 7, 1));
  packet[0] = 1;
  send(motes::hdlc_acked_packet(1, packet));
  settle();
  EXPECT_THAT(acks(), ElementsAre(1));
  EXPECT_THAT(packets(), IsEmpty());
}

TEST_F(SinkSerial, AcknowledgesUnknownAmTypesAndIgnoresThem) {
  auto packet = motes::packet_of(command(1, kProbe, 7, 1));
  packet[7] = 0x99;
  send(motes::hdlc_acked_packet(2, packet));
  settle();
  EXPECT_THAT(acks(), ElementsAre(2));
  EXPECT_THAT(packets(), IsEmpty());
}

TEST_F(SinkSerial, AcknowledgesAPayloadOf130BytesAndIgnoresIt) {
  Bytes record(130 - 14);
  send(3, command(1, record, 7, 1));
  settle();
  EXPECT_THAT(acks(), ElementsAre(3));
  EXPECT_THAT(packets(), IsEmpty());
}

TEST_F(SinkSerial, TakesAPayloadOf114Bytes) {
  Bytes record(100);
  send(3, command(1, record, 7, 1));
  settle();
  EXPECT_THAT(acknowledged(1), ElementsAre(7));
}

TEST_F(SinkSerial, IsSilentAboutABadCrcAndTakesTheNextFrame) {
  send(hex("7e440900ffff000102221c0102544c7e"));
  auto broken = probe(4, 8);
  broken[12] ^= 1;
  send(broken);
  send(probe(5, 9));
  settle();
  EXPECT_THAT(acks(), ElementsAre(5));
  EXPECT_THAT(acknowledged(1), ElementsAre(9));
}

TEST_F(SinkSerial, ExecutesTheSameSerialSequenceTwice) {
  for (int i = 0; i < 2; ++i) {
    send(probe(6, 10));
    settle();
  }
  EXPECT_THAT(acks(), ElementsAre(6, 6));
  EXPECT_THAT(acknowledged(1), ElementsAre(10, 10));
}

TEST_F(SinkSerial, ExecutesA45FrameWithoutAnAcknowledgement) {
  send(motes::hdlc_packet(motes::packet_of(command(1, kProbe, 11, 1))));
  settle();
  EXPECT_THAT(acks(), IsEmpty());
  EXPECT_THAT(acknowledged(1), ElementsAre(11));
}

TEST_F(SinkSerial, DoesNotLookAtDestinationSourceGroupAndLengthOfTheAmHeader) {
  for (const auto length : {std::uint8_t{5}, std::uint8_t{200}}) {
    auto packet = motes::packet_of(command(1, kProbe, length, 1));
    packet[1] = 0xab;
    packet[3] = 0xcd;
    packet[5] = length;
    packet[6] = 0x77;
    send(motes::hdlc_acked_packet(length, packet));
    settle();
  }
  EXPECT_THAT(acks(), ElementsAre(5, 200));
  EXPECT_THAT(acknowledged(1), ElementsAre(5, 200));
}

TEST_F(SinkSerial, LosesTheSecondOfTwoFramesThatShareAFlag) {
  auto both = probe(7, 12);
  const auto second = probe(8, 13);
  both.insert(both.end(), second.begin() + 1, second.end());
  send(both);
  settle();
  send(probe(9, 14));
  settle();
  EXPECT_THAT(acks(), ElementsAre(7, 9));
  EXPECT_THAT(acknowledged(1), ElementsAre(12, 14));
}

TEST_F(SinkSerial, LosesTheFrameBehindOneWithoutAClosingFlag) {
  auto open = probe(10, 15);
  open.pop_back();
  send(open);
  send(probe(11, 16));
  settle();
  send(probe(12, 17));
  settle();
  EXPECT_THAT(acks(), ElementsAre(10, 12));
  EXPECT_THAT(acknowledged(1), ElementsAre(15, 17));
}

TEST_F(SinkSerial, AcknowledgesTenAtOnceAndExecutesFour) {
  for (std::uint8_t i = 0; i < 10; ++i) send(probe(i, static_cast<std::uint16_t>(100 + i)));
  time.run_for(2s);
  EXPECT_THAT(acks(), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(acknowledged(1), SizeIs(4));
  EXPECT_EQ(count("overrun"), 6u);
}

TEST_F(SinkSerial, ForwardsFourOfTenAtOnceToAMote) {
  for (std::uint8_t i = 0; i < 10; ++i) send(probe(i, static_cast<std::uint16_t>(100 + i), 2));
  time.run_for(2s);
  EXPECT_THAT(acks(), SizeIs(10));
  EXPECT_EQ(count("ignored", 2), 4u);
}

TEST_F(SinkSerial, ExecutesTwoOfFourAtOnce) {
  for (std::uint8_t i = 0; i < 4; ++i) send(probe(i, static_cast<std::uint16_t>(100 + i)));
  time.run_for(2s);
  EXPECT_THAT(acks(), SizeIs(4));
  EXPECT_THAT(acknowledged(1), SizeIs(2));
}

TEST_F(SinkSerial, ExecutesAllWhereEachWaitsForTheAcknowledgementBefore) {
  for (std::uint8_t i = 0; i < 10; ++i) {
    send(probe(i, static_cast<std::uint16_t>(100 + i), i % 2 == 0 ? 1 : 2));
    while (acks().size() < i + 1U) time.run_for(1ms);
  }
  settle();
  EXPECT_THAT(acknowledged(1), SizeIs(5));
  EXPECT_EQ(count("ignored", 2), 5u);
}

TEST_F(SinkSerial, ExecutesAndAcknowledgesAMessageThatCountsNoBytes) {
  auto packet = motes::packet_of(command(1, kProbe, 18, 1));
  packet[8 + 11] = 0;
  send(motes::hdlc_acked_packet(13, packet));
  settle();
  EXPECT_THAT(acknowledged(1), ElementsAre(18));
}

TEST_F(SinkSerial, HandlesAMessageOfAnotherIslandThatIsForDevice1) {
  auto message = command(1, kProbe, 19, 1);
  message.destination_island = 77;
  send(14, message);
  settle();
  EXPECT_THAT(acknowledged(1), ElementsAre(19));
}

TEST_F(SinkSerial, RadioesAMessageOfAnotherIslandThatNoMoteTakes) {
  auto message = command(2, kProbe, 20, 1);
  message.destination_island = 77;
  send(15, message);
  settle();
  EXPECT_THAT(acks(), ElementsAre(15));
  EXPECT_THAT(packets(), IsEmpty());
  EXPECT_EQ(count("ignored", 2), 0u);
}

TEST_F(SinkSerial, DoesNothingWithAMessageForTheComputerItself) {
  send(probe(16, 21, motes::kBaseMote));
  settle();
  EXPECT_THAT(acks(), ElementsAre(16));
  EXPECT_THAT(packets(), IsEmpty());
}

TEST_F(SinkSerial, HasNoAnswerFromAMoteThatIsNotThere) {
  send(probe(17, 22, 9));
  settle();
  EXPECT_THAT(acks(), ElementsAre(17));
  EXPECT_THAT(packets(), IsEmpty());
}

TEST_F(SinkSerial, AcknowledgesWhenTheDelayIsOverAndTheLineIsThrough) {
  const auto frame = probe(18, 23);
  const auto begin = time.now();
  send(frame);
  settle();
  ASSERT_FALSE(came.empty());
  EXPECT_NEAR(std::chrono::duration<double>(came.front().at - begin).count(),
              static_cast<double>(frame.size() + 6) * 10 / 115200.0 + 0.05, 1e-6);
}

TEST_F(SinkSerial, DelaysItsAcknowledgementsByChance) {
  auto options = plain();
  options.sink.ack = {46ms, 67ms, 113ms, 0.1};
  joined(std::move(options));
  std::vector<Duration> delays;
  for (std::uint8_t i = 0; i < 100; ++i) {
    const auto begin = time.now();
    send(probe(i, i));
    time.run_for(300ms);
    delays.push_back(std::find_if(came.begin(), came.end(),
                                  [&](const auto& c) { return c.protocol == motes::kHdlcAck && c.sequence == i; })
                         ->at -
                     begin);
  }
  const auto [low, high] = std::minmax_element(delays.begin(), delays.end());
  EXPECT_GT(*low, 46ms);
  EXPECT_GT(*high, 113ms);
  EXPECT_LT(*high, 120ms);
  EXPECT_EQ(acknowledged(1).size(), 100u);
}

TEST_F(SinkSerial, TakesNoTimeIfConfigured) {
  auto options = plain();
  options.sink.ack = {{}, {}, {}, 0};
  options.sink.processing = 0;
  options.sink.baud = 0;
  joined(std::move(options));
  for (std::uint8_t i = 0; i < 20; ++i) {
    send(probe(i, i));
    time.run_for(1ms);
  }
  time.run_for(1ms);
  EXPECT_THAT(acks(), SizeIs(20));
  EXPECT_THAT(acknowledged(1), SizeIs(20));
}

TEST_F(SinkSerial, HasReadingsOfItsOwnOnlyBeyondTheRecordings) {
  for (const bool readings : {false, true}) {
    auto options = plain();
    options.sink.readings = readings;
    joined(std::move(options));
    const auto record = hex("01 0003 0200");
    send(1, command(1, record));
    time.run_for(3s);
    EXPECT_THAT(lights(1), SizeIs(readings ? 5 : 0));
  }
}

TEST_F(SinkSerial, LosesMessagesOfMotesThatTheLineIsTooSlowFor) {
  auto options = plain();
  options.sink.baud = 9600;  // 132 ms a message
  joined(std::move(options));
  const auto record = hex("01 0003 0040");
  send(1, command(2, record));
  time.run_for(10s);
  EXPECT_NEAR(static_cast<double>(lights(2).size()), 10 / 0.132, 5);
  EXPECT_GT(count("serial-full"), 70u);
}

TEST_F(SinkSerial, SurvivesEveryCorruptionOfAFrame) {
  const auto frame = probe(19, 24);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    for (const unsigned flip : {0x01U, 0x20U, 0x7eU, 0xffU}) {
      auto broken = frame;
      broken[i] = static_cast<std::uint8_t>(broken[i] ^ flip);
      send(broken);
      send(ByteView(frame).first(i));
    }
  }
  send(hex("7e7e"));
  time.run_for(10s);
  came.clear();
  send(probe(20, 25));
  settle();
  EXPECT_THAT(acks(), ElementsAre(20));
}

TEST_F(SinkSerial, HoldsAComputerThatSendsFasterThanTheLine) {
  for (int i = 0; i < 200; ++i) send(probe(static_cast<std::uint8_t>(i), 1));
  EXPECT_TRUE(world->sink(1).congested());
  int room = 0;
  world->sink(1).on_room([&room] { ++room; });
  time.run_for(1s);
  EXPECT_FALSE(world->sink(1).congested());
  EXPECT_EQ(room, 1);
}

TEST_F(SinkSerial, LosesWhatFindsItsTwoBuffersTaken) {
  SerialOutput output(115200, time);
  std::size_t left = 0;
  output.connect([&left](ByteView) { ++left; });
  const Bytes packet(122);
  EXPECT_TRUE(output.packet(packet));
  EXPECT_TRUE(output.packet(packet));
  EXPECT_FALSE(output.packet(packet));
  EXPECT_TRUE(output.ack(1)) << "acknowledgements have their own room";
  time.run_for(12ms);
  EXPECT_EQ(left, 2u);
  EXPECT_TRUE(output.packet(packet));
  time.run_for(1s);
  EXPECT_EQ(left, 4u);
}

}  // namespace
}  // namespace rubicon::motes_simulator
