#include "motes/mote_packet.h"

#include <gtest/gtest.h>

#include "motes/mote_records.h"

namespace rubicon::motes {
namespace {

/// A packet of the sink with this record, from mote 7 of island 42 to mote 0.
Bytes packet_of(const Record& record, std::uint8_t transport, std::uint8_t application) {
  NetMessage message;
  message.source_island = message.destination_island = 42;
  message.source_mote = 7;
  message.sequence = 3;
  message.transport = transport;
  message.application = application;
  const auto bytes = encode_record(record);
  message.record = bytes;
  const auto payload = encode_net(message);
  MotePacket packet;
  packet.am.type = static_cast<std::uint8_t>(AmType::kNetMessage);
  packet.am.length = static_cast<std::uint8_t>(payload.size());
  packet.payload = payload;
  return encode_packet(packet);
}

TEST(PacketText, NamesTheKindAndTheMotes) {
  RawUpdates updates;
  updates.readings.push_back({0x0001, {512}});
  const auto about = describe_packet(packet_of(updates, kTransportConnectionless, kApplicationControl));
  EXPECT_EQ(about.kind, "readings") << about.text;
  EXPECT_EQ(about.source, 7);
  EXPECT_EQ(about.destination, 0);
  EXPECT_EQ(about.text, "7 -> 0: light 512");
}

TEST(PacketText, OtherAndBrokenPacketsAreNamedToo) {
  EXPECT_EQ(describe_packet({}).kind, "malformed");
  EXPECT_FALSE(describe_packet({}).text.empty());
  const Bytes unknown{0x00, 0xff, 0xff, 0x00, 0x00, 0x02, 0x22, 0x77, 0x01, 0x02};
  EXPECT_EQ(describe_packet(unknown).kind, "packet");
  EXPECT_EQ(describe_packet(unknown).text, "AM type 77, 2 bytes");
  EXPECT_FALSE(describe_packet(unknown).source);
}

TEST(PacketText, NoBytesAreTooStrange) {
  Bytes bytes{0x00, 0xff, 0xff, 0x00, 0x00, 0x20, 0x22, 0x1c};
  for (int i = 0; i < 300; ++i) {
    EXPECT_FALSE(describe_packet(bytes).kind.empty());
    bytes.push_back(static_cast<std::uint8_t>(i * 37));
  }
}

}  // namespace
}  // namespace rubicon::motes
