#include "motes/framing.h"

#include <gmock/gmock.h>

#include "motes/mote_vectors.h"
#include "motes/serial_lines.h"

namespace rubicon::motes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Packets until the bytes are used up or the reader gives up.
std::vector<Bytes> packets_in(ForwarderReader& reader, ByteView bytes) {
  std::vector<Bytes> packets;
  while (true) {
    const auto packet = reader.next(bytes);
    if (!packet || !*packet) return packets;
    packets.emplace_back((*packet)->begin(), (*packet)->end());
  }
}

const Bytes kConfig = hex("0000010000030025 0a7d7e");

TEST(ForwarderStream, PacketsFollowTheGreeting) {
  ForwarderReader reader;
  EXPECT_FALSE(reader.greeted());
  // wsn.md 4.3: SET_ISLAND_ID 7d7e, no escapes at this level.
  EXPECT_THAT(packets_in(reader, hex("5520 0b 0000010000030025 0a7d7e 0a 00ffff000102221c0102")),
              ElementsAre(kConfig, hex("00ffff000102221c0102")));
  EXPECT_TRUE(reader.greeted());
}

TEST(ForwarderStream, APacketHasTheBytesOfTheOriginal) {
  EXPECT_EQ(forwarder_packet(kConfig), hex("0b 0000010000030025 0a7d7e"));
  EXPECT_EQ(forwarder_packet(Bytes(255, 1)).size(), 256u);
}

TEST(ForwarderStream, PacketsOfAnyLengthArriveInPiecesOfAnySize) {
  Bytes stream(kForwarderHello.begin(), kForwarderHello.end());
  for (std::size_t length = 1; length <= 255; ++length)
    stream = stream + forwarder_packet(Bytes(length, static_cast<std::uint8_t>(length)));
  for (const std::size_t piece : {1u, 2u, 3u, 127u, 256u, 100'000u}) {
    ForwarderReader reader;
    std::vector<Bytes> packets;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      for (Bytes& packet : packets_in(reader, ByteView(stream).subspan(at, std::min(piece, stream.size() - at))))
        packets.push_back(std::move(packet));
    }
    ASSERT_EQ(packets.size(), 255u) << piece;
    for (std::size_t i = 0; i < 255; ++i)
      ASSERT_EQ(packets[i], Bytes(i + 1, static_cast<std::uint8_t>(i + 1))) << piece;
  }
}

std::string fault_of(ForwarderReader& reader, ByteView bytes) {
  while (true) {
    const auto packet = reader.next(bytes);
    if (!packet) return packet.error().text;
    if (!*packet) return "";
  }
}

TEST(ForwarderStream, NewerVersionsAreAcceptedAndOlderRefused) {
  for (const char* greeting : {"5520", "5521", "55ff"}) {
    ForwarderReader reader;
    EXPECT_EQ(fault_of(reader, hex(greeting)), "") << greeting;
    EXPECT_TRUE(reader.greeted()) << greeting;
  }
  ForwarderReader old;
  EXPECT_EQ(fault_of(old, hex("551f")), "version 1f of the serial-forwarder protocol, expected 20 or newer");
  EXPECT_FALSE(old.greeted());
}

TEST(ForwarderStream, APeerOfAnotherProtocolIsRefusedForGood) {
  ForwarderReader reader;
  EXPECT_THAT(fault_of(reader, base::as_bytes("GET / HTTP/1.1")), HasSubstr("greeted with 47, expected 55"));
  EXPECT_THAT(fault_of(reader, hex("5520")), HasSubstr("greeted with 47, expected 55"));
  EXPECT_THAT(fault_of(reader, {}), HasSubstr("greeted with 47, expected 55"));
}

TEST(ForwarderStream, APacketOfNothingEndsTheStreamBehindThoseBefore) {
  ForwarderReader reader;
  ByteView bytes;
  const Bytes stream = hex("5520 0a00ffff000102221c0102 00 0a00ffff000102221c0102");
  bytes = stream;
  const auto first = reader.next(bytes);
  ASSERT_TRUE(first && *first);
  const auto second = reader.next(bytes);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(second.error().text, HasSubstr("a packet of 0 bytes"));
  EXPECT_FALSE(reader.next(bytes).has_value());
}

TEST(ForwarderStream, ACutStreamGivesItsWholePackets) {
  const Bytes stream = hex("5520 0b0000010000030025 0a7d7e 0a00ffff000102221c0102");
  for (std::size_t length = 0; length <= stream.size(); ++length) {
    ForwarderReader reader;
    const auto packets = packets_in(reader, ByteView(stream).first(length));
    EXPECT_EQ(packets.size(), length < 14 ? 0u : length < 25 ? 1u : 2u) << length;
  }
}

/// What the forwarder and its client exchanged while the serial line was recorded.
struct Exchange {
  std::string tcp, serial;
  std::size_t packets;
};

class ForwarderRecordings : public testing::TestWithParam<Exchange> {};

TEST_P(ForwarderRecordings, HoldTheSamePacketsAsTheSerialLine) {
  const Bytes tcp = recorded(GetParam().tcp), serial = recorded(GetParam().serial);
  if (tcp.empty() || serial.empty()) GTEST_SKIP() << "the recordings are not here";
  std::vector<Bytes> on_the_line;
  for (const Heard& heard : heard_in(serial)) {
    if (heard.protocol != kHdlcAck) on_the_line.push_back(heard.packet);
  }
  ForwarderReader reader;
  const auto packets = packets_in(reader, tcp);
  EXPECT_TRUE(reader.greeted());
  EXPECT_EQ(packets.size(), GetParam().packets);
  EXPECT_EQ(packets, on_the_line);

  Bytes again(kForwarderHello.begin(), kForwarderHello.end());
  for (const Bytes& packet : packets) again = again + forwarder_packet(packet);
  EXPECT_EQ(again, tcp);
}

INSTANTIATE_TEST_SUITE_P(Shared, ForwarderRecordings,
                         testing::Values(Exchange{"avr_sf_tcp_rx.bin", "avr_sink_uart_mote2pc.bin", 57},
                                         Exchange{"origjava_sf_tcp_sf2pc.bin", "origjava_uart_mote2pc.bin", 37},
                                         Exchange{"origjava_sf_tcp_pc2sf.bin", "origjava_uart_pc2mote.bin", 4}),
                         [](const auto& test) { return test.param.tcp.substr(0, test.param.tcp.find('.')); });

TEST(ForwarderVectors, AreReadAndWrittenByteForByte) {
  std::size_t met = 0;
  for (const Vector& vector : shared_vectors()) {
    if (vector.kind != "sf" && vector.kind != "sf-hello") continue;
    ForwarderReader reader;
    if (vector.kind == "sf-hello") {
      EXPECT_TRUE(packets_in(reader, vector.bytes).empty());
      EXPECT_TRUE(reader.greeted());
    } else {
      packets_in(reader, kForwarderHello);
      const auto packets = packets_in(reader, vector.bytes);
      ASSERT_EQ(packets.size(), 1u) << vector.name;
      EXPECT_EQ(forwarder_packet(packets[0]), vector.bytes) << vector.name;
    }
    ++met;
  }
  if (met == 0) GTEST_SKIP() << "no ../shared/data/motes/vectors.tsv beside the source tree";
  EXPECT_EQ(met, 8u);
}

}  // namespace
}  // namespace rubicon::motes
