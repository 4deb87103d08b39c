#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.h"

namespace rubicon::motes {

/// Special addresses (wsn.md 6). kBaseMote is the computer of an island's sink.
inline constexpr std::uint16_t kBaseMote = 0xfffd;
inline constexpr std::uint16_t kBroadcast = 0xffff;
inline constexpr std::uint16_t kSinkMote = 1;

/// AM types that we know (wsn.md 6).
enum class AmType : std::uint8_t { kCommand = 0x0b, kSerialData = 0x0c, kNetMessage = 0x1c, kConfig = 0x25 };

/// Component ids of the motes: the first two bytes after the NetMsg header (wsn.md 6).
inline constexpr std::uint8_t kTransportSynaptic = 1;
inline constexpr std::uint8_t kTransportConnectionless = 3;
inline constexpr std::uint8_t kTransportAck = 9;
inline constexpr std::uint8_t kApplicationMockup = 5;
inline constexpr std::uint8_t kApplicationLearning = 6;
inline constexpr std::uint8_t kApplicationControl = 10;
inline constexpr std::uint8_t kApplicationSynaptic = 11;

/// Serial AM header, 7 bytes after the dispatch byte 00 (wsn.md 3). `length` is the value of its field; the real length
/// of the payload follows from the frame.
struct AmHeader {
  std::uint16_t destination = 0;
  std::uint16_t source = 0;
  std::uint8_t length = 0;
  std::uint8_t group = 0;
  std::uint8_t type = 0;

  friend bool operator==(const AmHeader&, const AmHeader&) = default;
};

/// What sink and computer exchange: dispatch byte, AM header, payload; no framing. A view of the decoded bytes.
struct MotePacket {
  AmHeader am;
  ByteView payload;

  bool is(AmType type) const { return am.type == static_cast<std::uint8_t>(type); }
};

/// The radio message inside a packet of AM type 1C (wsn.md 5). `counted` is its nbytes field, which is wrong in
/// all messages that a sink forwards. `record` extends to the end of the frame and may end with padding or stale memory
/// of the mote; a view.
struct NetMessage {
  std::uint16_t destination_island = 0;
  std::uint16_t destination_mote = 0;
  std::uint16_t source_island = 0;
  std::uint16_t source_mote = 0;
  std::uint8_t reliable = 0;
  std::uint16_t sequence = 0;
  std::uint8_t counted = 0;
  std::uint8_t transport = 0;
  std::uint8_t application = 0;
  ByteView record;
};

/// Longest packet that a length byte can express (serial-forwarder protocol, recorder).
inline constexpr std::size_t kMaxPacket = 255;
/// Longest AM payload that a sink accepts (wsn.md 12).
inline constexpr std::size_t kMaxPayload = 114;
/// Dispatch byte and AM header.
inline constexpr std::size_t kAmOverhead = 8;

Result<MotePacket> decode_packet(ByteView bytes);
/// Writes `am.length` unchanged; packet_of() sets the true length.
Bytes encode_packet(const MotePacket& packet);

/// Decodes a packet's payload; needs NetMsg header, transport, application and a first record byte (15 bytes, wsn.md
/// 3).
Result<NetMessage> decode_net(ByteView payload);
Bytes encode_net(const NetMessage& message);

/// The bytes of a packet from the computer to the sink with true lengths, not padded (wsn.md 3). Asserts that the
/// payload has at most 247 bytes.
Bytes packet_of(AmType type, ByteView payload);
Bytes packet_of(NetMessage message);

/// What a packet is, for people and tools that watch the traffic of a sink.
struct PacketText {
  /// join, readings, sampling, actuate, acknowledge, record (of an application), config, packet (of another AM type) or
  /// malformed.
  std::string_view kind;
  std::optional<std::uint16_t> source, destination;  ///< motes; only in radio messages
  std::string text;                                  ///< raw counts, as they stand in the packet
};
/// Never fails: a packet that cannot be decoded is malformed, and the text says why.
PacketText describe_packet(ByteView bytes);

}  // namespace rubicon::motes
