#include "motes/mote_packet.h"

#include <fmt/format.h>

#include "base/assert.h"

namespace rubicon::motes {

namespace {

// NetMsg header (12), transport id, application id, record type (wsn.md 5).
constexpr std::size_t kShortestNet = 15;
constexpr std::uint8_t kDispatch = 0;
constexpr std::uint16_t kSinkAm = 1;

}  // namespace

Result<MotePacket> decode_packet(ByteView bytes) {
  if (bytes.size() < kAmOverhead || bytes.size() > kMaxPacket) {
    return fail(ErrorCode::kInvalid,
                fmt::format("mote packet of {} bytes, expected {} to {}", bytes.size(), kAmOverhead, kMaxPacket));
  }
  base::ByteReader reader(bytes);
  if (const auto dispatch = reader.u8(); dispatch != kDispatch) {
    return fail(ErrorCode::kInvalid, fmt::format("mote packet with dispatch byte {:02x}, expected 00", dispatch));
  }
  MotePacket packet;
  packet.am.destination = reader.u16_be();
  packet.am.source = reader.u16_be();
  packet.am.length = reader.u8();
  packet.am.group = reader.u8();
  packet.am.type = reader.u8();
  packet.payload = reader.take(reader.remaining());
  return packet;
}

Bytes encode_packet(const MotePacket& packet) {
  base::ByteWriter writer;
  writer.u8(kDispatch).u16_be(packet.am.destination).u16_be(packet.am.source);
  writer.u8(packet.am.length).u8(packet.am.group).u8(packet.am.type).bytes(packet.payload);
  return writer.take();
}

Result<NetMessage> decode_net(ByteView payload) {
  if (payload.size() < kShortestNet) {
    return fail(ErrorCode::kInvalid,
                fmt::format("radio message of {} bytes, expected at least {}", payload.size(), kShortestNet));
  }
  base::ByteReader reader(payload);
  NetMessage message;
  message.destination_island = reader.u16_be();
  message.destination_mote = reader.u16_be();
  message.source_island = reader.u16_be();
  message.source_mote = reader.u16_be();
  message.reliable = reader.u8();
  message.sequence = reader.u16_be();
  message.counted = reader.u8();
  message.transport = reader.u8();
  message.application = reader.u8();
  message.record = reader.take(reader.remaining());
  return message;
}

Bytes encode_net(const NetMessage& message) {
  base::ByteWriter writer;
  writer.u16_be(message.destination_island).u16_be(message.destination_mote);
  writer.u16_be(message.source_island).u16_be(message.source_mote);
  writer.u8(message.reliable).u16_be(message.sequence).u8(message.counted);
  writer.u8(message.transport).u8(message.application).bytes(message.record);
  return writer.take();
}

Bytes packet_of(AmType type, ByteView payload) {
  RUBICON_ASSERT(payload.size() <= kMaxPacket - kAmOverhead);
  MotePacket packet;
  packet.am.destination = kSinkAm;
  packet.am.type = static_cast<std::uint8_t>(type);
  packet.am.length = static_cast<std::uint8_t>(payload.size());
  packet.payload = payload;
  return encode_packet(packet);
}

Bytes packet_of(NetMessage message) {
  message.counted = static_cast<std::uint8_t>(message.record.size() + 2);
  return packet_of(AmType::kNetMessage, encode_net(message));
}

}  // namespace rubicon::motes
