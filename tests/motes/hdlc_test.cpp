#include "motes/framing.h"

#include <gmock/gmock.h>

#include "motes/mote_records.h"
#include "motes/serial_lines.h"

namespace rubicon::motes {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// wsn.md 15: SET_ISLAND_ID and the acknowledgement of serial sequence number 0e.
const Bytes kConfig42 = hex("00 0001 0000 03 00 25 0a 002a");
const Bytes kConfig42Frame = hex("7e440e00000100000300250a002acaa37e");
const Bytes kAck0e = hex("7e430e51b97e");
const Heard kHeardAck0e{kHdlcAck, 0x0e, {}};

TEST(Hdlc, ChecksumHasItsCheckValue) {
  EXPECT_EQ(crc16(base::as_bytes("123456789")), 0x31c3);
  EXPECT_EQ(crc16({}), 0);
}

TEST(Hdlc, ChecksumOfPartsIsThatOfTheWhole) {
  Bytes bytes;
  for (int i = 0; i < 300; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 37));
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut)
    ASSERT_EQ(crc16(ByteView(bytes).subspan(cut), crc16(ByteView(bytes).first(cut))), crc16(bytes)) << cut;
}

TEST(Hdlc, FramesWeSendEqualTheOriginals) {
  EXPECT_EQ(hdlc_acked_packet(0x0e, kConfig42), kConfig42Frame);
  EXPECT_EQ(hdlc_acked_packet(0x0f, kConfig42), hex("7e440f00000100000300250a002abfa07e"));
  EXPECT_EQ(hdlc_acked_packet(0x10, kConfig42), hex("7e441000000100000300250a002a0c847e"));
  EXPECT_EQ(hdlc_acked_packet(0x26, kConfig42), hex("7e442600000100000300250a002ac2d67e"));
  EXPECT_EQ(hdlc_acked_packet(0x0e, hex("00000100000300250a000b")), hex("7e440e00000100000300250a000b89977e"));
  EXPECT_EQ(hdlc_acked_packet(0x26, hex("00000100000300250a000c")), hex("7e442600000100000300250a000c66927e"));
  EXPECT_EQ(hdlc_ack(0x0e), kAck0e);
  EXPECT_EQ(hdlc_ack(0x63), hex("7e43635a047e"));
  EXPECT_EQ(hdlc_packet(hex("00ffff000102221c0102")), hex("7e4500ffff000102221c0102dd2b7e"));
}

TEST(Hdlc, FlagsAndEscapesInsideAreEscaped) {
  const Bytes packet = hex("00000100000300250a7d7e");
  EXPECT_EQ(hdlc_acked_packet(0x0e, packet), hex("7e440e00000100000300250a7d5d7d5ebec77e"));
  EXPECT_EQ(hdlc_acked_packet(0x7e, packet), hex("7e447d5e00000100000300250a7d5d7d5e0e437e"));
  EXPECT_EQ(hdlc_ack(0x7e), hex("7e437d5ec6c77e"));
}

TEST(Hdlc, ACommandIsTheFrameThatASinkExecuted) {
  const auto sent = [](std::uint8_t sequence, NetMessage message, const Record& record) {
    const Bytes bytes = encode_record(record);
    message.record = bytes;
    return hdlc_acked_packet(sequence, packet_of(message));
  };
  const auto app = kApplicationMockup;
  EXPECT_EQ(sent(0x26, {11, 2, 11, kBaseMote, 0, 0x1234, 0, 3, app, {}}, PeriodicCommand{0x0043, 1000}),
            hex("7e4426000001000013001c000b0002000bfffd00123407030501004303e88d3a7e"));
  EXPECT_EQ(sent(0x2a, {11, 3, 11, kBaseMote, 1, 0x0103, 0, 3, app, {}}, ActuateCommand{1, 1}),
            hex("7e442a000001000015001c000b0003000bfffd01010309030502000100000001 6213 7e"));
}

/// Essential frames of wsn.md 15, from either side.
std::vector<Bytes> essential_frames() {
  const std::string head = "7e4500 ffff0000 72 00 1c ", java = "7e4500 ffff0001 72 22 1c ";
  return {
      kConfig42Frame,
      kAck0e,
      hex("7e440e00000100000300250a7d5d7d5ebec77e"),
      hex("7e447d5e00000100000300250a7d5d7d5e0e437e"),
      padded(head + "002afffd002a000500000066 030a 10002a0005011f4f01", 91, "a8cf7e"),
      padded(head + "000bfffd000b000200000066 030a 10000b00020100b001", 91, "0fcf7e"),
      padded(java + "000bfffd000b000500000066 030a 10000b000501004301", 91, "0c267e"),
      padded(head + "002afffd002a000500123466 030a 23030001012c00021964004004b0", 86, "bedd7e"),
      padded(java + "000bfffd000b000500123466 030a 23010001012c", 94, "9c597e"),
      padded(java + "000bfffd000b000500123466 030a 23020001012c00021964", 90, "f4447e"),
      padded(java + "000bfffd000b000500123466 030a 23050001012c00021964004004b0001000010020004d", 78, "f49e7e"),
      padded(java + "000bfffd000b000500123466 030a 2301000401f40009", 92, "4abf7e"),
      padded(head + "000bfffd000b000200247f66 0305 22012c1964", 95, "e0e17e"),
      padded(head + "000bfffd000b00030030a966 0905 17beef00 64", 95, "f1f37e"),
      padded(head + "000bfffd000b000100089b06 0905 17010600 28", 95, "f0ce7e"),
      padded("7e4411 00 00010000 72 00 1c 000b0005000bfffd01b36807 030a 2401f40043", 95, "7a987e"),
      padded("7e440f 00 00010000 72 00 1c 000b0005000bfffd00f70706 090a 17123400", 96, "dc797e"),
      hex("7e4426 00 00010000 13 00 1c 000b0002000bfffd00123407 0305 01004303e8 8d3a7e"),
      hex("7e442a 00 00010000 15 00 1c 000b0003000bfffd01010309 0305 02000100000001 62137e"),
      hex("7e43635a047e"),
      hex("7e43263b1c7e"),
      hex("7e432d50ad7e"),
  };
}

TEST(Hdlc, EveryEssentialFrameIsReadAndWrittenTheSame) {
  for (const Bytes& frame : essential_frames()) {
    const auto heard = heard_in(frame);
    ASSERT_EQ(heard.size(), 1u) << base::to_hex(frame);
    EXPECT_EQ(base::to_hex(written(heard[0])), base::to_hex(frame));
  }
}

TEST(Hdlc, TheEightAcknowledgementsOfARecordedSinkAreRead) {
  const auto heard = heard_in(
      hex("7e43263b1c7e 7e43271a0c7e 7e4328f5fd7e 7e4329d4ed7e 7e432ab7dd7e 7e432b96cd7e 7e432c71bd7e 7e432d50ad7e"));
  ASSERT_EQ(heard.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(heard[i], (Heard{kHdlcAck, static_cast<std::uint8_t>(0x26 + i), {}}));
}

TEST(Hdlc, TwoFramesMayShareAFlag) {
  const Bytes packet = hex("00ffff000102221c0102");
  EXPECT_THAT(heard_in(hex("7e440c00ffff000102221c01025bc57e440d00ffff000102221c0102121d7e")),
              ElementsAre(Heard{kHdlcAckedPacket, 0x0c, packet}, Heard{kHdlcAckedPacket, 0x0d, packet}));
}

TEST(Hdlc, ARepeatedSequenceNumberIsNotHeldBack) {
  EXPECT_EQ(heard_in(kConfig42Frame + kConfig42Frame).size(), 2u);
}

TEST(Hdlc, EmptyFramesAreSkippedSilently) {
  HdlcReader reader;
  std::vector<Heard> heard;
  hear(reader, hex("7e7e7e7e") + kAck0e + hex("7e7e"), heard);
  EXPECT_THAT(heard, ElementsAre(kHeardAck0e));
  EXPECT_EQ(reader.faults(), HdlcFaults{});
}

TEST(Hdlc, TextBeforeTheFirstFlagIsSkippedAndCounted) {
  HdlcReader reader;
  std::vector<Heard> heard;
  hear(reader, hex("676172626167657e440e00ffff000102221c0102e8657e"), heard);
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(heard[0].sequence, 0x0e);
  EXPECT_EQ(reader.faults(), HdlcFaults{.bytes_between = 7});
}

struct Fault {
  const char* name;
  Bytes bytes;
  HdlcFaults counted;
};

std::vector<Fault> faults() {
  return {
      {"wrong CRC", hex("7e440900ffff000102221c0102544c7e"), {.bad_crc = 1}},
      {"two bytes", hex("7e01027e"), {.too_short = 1}},
      {"a packet of nothing", hex("7e4561187e"), {.too_short = 1}},
      {"unknown protocol byte", hex("7e4601020334287e"), {.unknown_protocols = 1}},
      {"an answer to an unknown protocol byte", hex("7eff46fd2b7e"), {}},
      {"escaped flag", hex("7e4401027d7e"), {.broken_escapes = 1}},
      {"garbage after an escaped flag", hex("7e4401027d7e010203"), {.broken_escapes = 1, .bytes_between = 3}},
      {"cut off", hex("7e440e000001"), {.bad_crc = 1}},
  };
}

TEST(Hdlc, InvalidFramesAreCountedAndTheNextOneIsRead) {
  for (const Fault& fault : faults()) {
    HdlcReader reader;
    std::vector<Heard> heard;
    hear(reader, fault.bytes + kAck0e, heard);
    EXPECT_THAT(heard, ElementsAre(kHeardAck0e)) << fault.name;
    EXPECT_EQ(reader.faults(), fault.counted) << fault.name;
  }
}

TEST(Hdlc, AFlagBehindAnEscapeOpensNothing) {
  EXPECT_THAT(heard_in(hex("7e4401027d") + kAck0e), IsEmpty());
  EXPECT_THAT(heard_in(hex("7e4401027d") + kAck0e + kAck0e), ElementsAre(kHeardAck0e));
}

/// A valid frame with this many bytes between its flags, before escapes, with CRC.
Bytes frame_of_size(std::size_t size) {
  Bytes packet(size - 3);
  for (std::size_t i = 0; i < packet.size(); ++i) packet[i] = static_cast<std::uint8_t>(i * 7);
  return hdlc_packet(packet);
}

TEST(Hdlc, TheLongestFrameIsHeardAndLongerOnesAreDropped) {
  ASSERT_EQ(heard_in(frame_of_size(256)).size(), 1u);
  EXPECT_EQ(heard_in(frame_of_size(256))[0].packet.size(), 253u);
  for (const std::size_t size : {257u, 265u, 1000u, 100'000u}) {
    HdlcReader reader;
    std::vector<Heard> heard;
    hear(reader, frame_of_size(size) + kAck0e, heard);
    EXPECT_THAT(heard, ElementsAre(kHeardAck0e)) << size;
    EXPECT_EQ(reader.faults(), HdlcFaults{.too_long = 1}) << size;
  }
}

TEST(Hdlc, AFrameAtTheLimitMayEndInAnEscape) {
  Bytes packet(253);
  const auto ends_in_an_escape = [&] { return crc16(packet, crc16(std::array{kHdlcPacket})) >> 8 == 0x7d; };
  for (unsigned tail = 0; tail < 0x10000 && !ends_in_an_escape(); ++tail) {
    packet[251] = static_cast<std::uint8_t>(tail >> 8);
    packet[252] = static_cast<std::uint8_t>(tail);
  }
  ASSERT_TRUE(ends_in_an_escape());
  EXPECT_EQ(heard_in(hdlc_packet(packet)).size(), 1u);
}

TEST(Hdlc, AnyByteTravelsAnywhere) {
  for (int byte = 0; byte < 256; ++byte) {
    for (std::size_t length = 1; length < 20; ++length) {
      const Bytes packet(length, static_cast<std::uint8_t>(byte));
      const auto sequence = static_cast<std::uint8_t>(byte ^ 0x5a);
      ASSERT_THAT(heard_in(hdlc_acked_packet(sequence, packet)),
                  ElementsAre(Heard{kHdlcAckedPacket, sequence, packet}));
    }
  }
}

TEST(Hdlc, AReopenedLineDiscardsThePartialFrame) {
  HdlcReader reader;
  std::vector<Heard> heard;
  hear(reader, ByteView(kConfig42Frame).first(9), heard);
  reader.reset();
  hear(reader, ByteView(kConfig42Frame).subspan(9), heard);
  EXPECT_THAT(heard, IsEmpty());
  hear(reader, kAck0e, heard);
  EXPECT_THAT(heard, ElementsAre(kHeardAck0e));
}

TEST(Hdlc, EveryPrefixOfAFrameIsSurvivedAndTheNextHeard) {
  for (const Bytes& frame : essential_frames()) {
    // Up to the closing flag: where that alone is missing the next frame's flag closes it.
    for (std::size_t length = 0; length + 1 < frame.size(); ++length) {
      const Bytes prefix(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(length));
      const auto heard = heard_in(prefix + kAck0e + kAck0e);
      // An escape at the end of the prefix costs the frame after it.
      ASSERT_GE(heard.size(), length > 0 && prefix.back() == 0x7d ? 1u : 2u) << base::to_hex(prefix);
      for (const Heard& one : heard) ASSERT_EQ(one, kHeardAck0e) << base::to_hex(prefix);
    }
  }
}

TEST(Hdlc, NoCorruptedByteGivesAnotherFrameOrLosesThoseBehindIt) {
  for (const Bytes& frame : essential_frames()) {
    const Heard whole = heard_in(frame).at(0);
    for (std::size_t at = 0; at < frame.size(); ++at) {
      for (const int value : {0x00, 0x7d, 0x7e, 0xff, frame[at] ^ 0x01, frame[at] ^ 0x20, frame[at] ^ 0x80}) {
        Bytes damaged = frame;
        damaged[at] = static_cast<std::uint8_t>(value);
        const auto heard = heard_in(damaged + kConfig42Frame + kAck0e);
        ASSERT_GE(heard.size(), 1u);
        ASSERT_EQ(heard.back(), kHeardAck0e) << base::to_hex(damaged);
        for (const Heard& one : heard) {
          const bool known = one == whole || one == kHeardAck0e || one.packet == kConfig42;
          ASSERT_TRUE(known) << base::to_hex(damaged);
        }
      }
    }
  }
}

TEST(Hdlc, RandomBytesAreSurvivedAndTheFrameBehindThemHeard) {
  std::mt19937 random(4711);
  HdlcReader reader;
  for (int round = 0; round < 2000; ++round) {
    Bytes garbage(random() % 400);
    for (auto& byte : garbage) byte = static_cast<std::uint8_t>(random() % 3 == 0 ? 0x7c + random() % 4 : random());
    std::vector<Heard> heard;
    hear(reader, garbage + kAck0e + kAck0e, heard);
    ASSERT_FALSE(heard.empty()) << round;
    ASSERT_EQ(heard.back(), kHeardAck0e) << round;
  }
}

}  // namespace
}  // namespace rubicon::motes
