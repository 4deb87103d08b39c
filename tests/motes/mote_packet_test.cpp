#include "motes/mote_packet.h"

#include <gtest/gtest.h>

#include "motes/mote_records.h"

namespace rubicon::motes {
namespace {

TEST(MotePacket, SetIslandIdHasTheBytesOfTheOriginal) {
  EXPECT_EQ(base::to_hex(packet_of(AmType::kConfig, encode_config({kSetIslandId, 42}))), "00000100000300250a002a");
}

NetMessage command(std::uint16_t mote, std::uint16_t sequence, ByteView record) {
  return {11, mote, 11, kBaseMote, 1, sequence, 0, kTransportConnectionless, kApplicationMockup, record};
}

Bytes command_packet(std::uint16_t mote, std::uint16_t sequence, const Record& record) {
  return packet_of(command(mote, sequence, encode_record(record)));
}

// The frames of wsn.md 15 without their framing.
TEST(MotePacket, PeriodicCommandHasTheBytesThatASinkExecutes) {
  EXPECT_EQ(base::to_hex(command_packet(2, 0x1234, PeriodicCommand{0x0043, 1000})),
            "000001000013001c000b0002000bfffd01123407030501004303e8");
}

TEST(MotePacket, ActuateCommandHasTheBytesThatASinkExecutes) {
  EXPECT_EQ(base::to_hex(command_packet(3, 0x0103, ActuateCommand{1, 1})),
            "000001000015001c000b0003000bfffd01010309030502000100000001");
}

TEST(MotePacket, NegativeActuatorValuesReadBack) {
  const Bytes bytes = encode_record(ActuateCommand{2, -5});
  const auto record = decode_record(command(3, 1, bytes));
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(std::get<ActuateCommand>(*record).value, -5);
}

TEST(MotePacket, TheFrameSaysHowLongThePayloadIs) {
  for (const char* length : {"05", "15", "c8"}) {
    const auto bytes =
        base::from_hex(std::string("00ffff0000") + length + "001c0102030405060708090a0b0c0d0e0f101112131415");
    const auto packet = decode_packet(*bytes);
    ASSERT_TRUE(packet.has_value());
    EXPECT_EQ(packet->payload.size(), 21u);
  }
}

TEST(MotePacket, RefusesWhatIsTooShortTooLongOrOfAnotherKind) {
  EXPECT_FALSE(decode_packet(Bytes(7, 0)).has_value());
  EXPECT_FALSE(decode_packet(Bytes(256, 0)).has_value());
  Bytes other(20, 0);
  other[0] = 1;
  const auto packet = decode_packet(other);
  ASSERT_FALSE(packet.has_value());
  EXPECT_EQ(packet.error().text, "mote packet with dispatch byte 01, expected 00");
  EXPECT_FALSE(decode_net(Bytes(14, 0)).has_value());
  EXPECT_TRUE(decode_net(Bytes(15, 0)).has_value());
}

TEST(MotePacket, IsDecodedWholeOrNotAtAll) {
  const auto bytes = command_packet(3, 0x0103, ActuateCommand{1, -5});
  const auto decoded = decode_whole(bytes);
  ASSERT_TRUE(decoded.has_value());
  ASSERT_TRUE(decoded->radio.has_value());
  EXPECT_EQ(decoded->radio->header.sequence, 0x0103);
  EXPECT_EQ(std::get<ActuateCommand>(decoded->radio->record).value, -5);
  EXPECT_FALSE(decode_whole(ByteView(bytes).first(7)).has_value()) << "no AM header";
  EXPECT_FALSE(decode_whole(ByteView(bytes).first(kAmOverhead + 14)).has_value()) << "no radio message";
  EXPECT_FALSE(decode_whole(ByteView(bytes).first(bytes.size() - 1)).has_value()) << "a record that is cut short";
}

TEST(MotePacket, OfAnotherAmTypeHasNoRadioMessage) {
  const auto bytes = packet_of(AmType::kConfig, encode_config({kSetIslandId, 42}));
  const auto decoded = decode_whole(bytes);
  ASSERT_TRUE(decoded.has_value());
  EXPECT_TRUE(decoded->packet.is(AmType::kConfig));
  EXPECT_FALSE(decoded->radio.has_value());
}

TEST(MoteRecords, UpdatesOfMoreThan49WordsAreRefused) {
  const auto decode = [](std::uint8_t count) {
    NetMessage message;
    message.transport = kTransportConnectionless;
    message.application = kApplicationControl;
    Bytes record{0x23, count};
    for (int i = 0; i < count; ++i) record.insert(record.end(), {0x00, 0x01, 0x00, 0x07});
    message.record = record;
    return decode_record(message);
  };
  EXPECT_TRUE(decode(24).has_value());
  EXPECT_FALSE(decode(25).has_value());
}

TEST(MoteRecords, AnUnknownTransducerHasOneWord) {
  EXPECT_EQ(words_of(0x2000), 1u);
  EXPECT_EQ(words_of(0x0004), 2u);
  EXPECT_EQ(words_of(0x0100), 5u);
}

}  // namespace
}  // namespace rubicon::motes
