#include "motes/mote_packet.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "motes/mote_records.h"

namespace rubicon::motes {

namespace {

// NetMsg header (12), transport id, application id, record type (wsn.md 5).
constexpr std::size_t kMinNet = 15;
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
  if (payload.size() < kMinNet) {
    return fail(ErrorCode::kInvalid,
                fmt::format("radio message of {} bytes, expected at least {}", payload.size(), kMinNet));
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

namespace {

/// By mask bit (wsn.md 6).
constexpr std::array<std::string_view, 13> kTransducerNames{
    "light",    "temperature", "acceleration-x", "acceleration-y", "pir",    "microphone", "humidity",
    "magnetic", "rssi-1",      "rssi-2",         "rssi-3",         "rssi-4", "rssi-5"};

std::string names_of(std::uint16_t mask) {
  std::vector<std::string_view> names;
  for (std::size_t bit = 0; bit < kTransducerNames.size(); ++bit) {
    if ((mask & (1U << bit)) != 0) names.push_back(kTransducerNames[bit]);
  }
  return names.empty() ? "nothing" : fmt::format("{}", fmt::join(names, ", "));
}

std::string sampling_text(std::uint16_t transducers, std::uint16_t period) {
  if (transducers == 0) return "stop sampling";
  return fmt::format("sample {} each {} ms", names_of(transducers), period);
}

/// Kind and text of each record.
struct Describe {
  using Described = std::pair<std::string_view, std::string>;

  Described operator()(const Joined& joined) const {
    return {"join", fmt::format("mote {} of island {}, type {}: {}; {} actuators", joined.mote, joined.island,
                                joined.mote_type, names_of(joined.transducers), joined.actuators)};
  }
  Described operator()(const RawUpdates& updates) const {
    std::vector<std::string> items;
    for (const auto& reading : updates.readings)
      items.push_back(fmt::format("{} {}", names_of(reading.transducer), fmt::join(reading.words, " ")));
    return {"readings", fmt::format("{}", fmt::join(items, ", "))};
  }
  Described operator()(const DemoReport& report) const {
    return {"readings", fmt::format("light {}, temperature {}", report.light, report.temperature)};
  }
  Described operator()(const ReadUpdates& read) const {
    return {"sampling", sampling_text(read.transducers, read.period_ms)};
  }
  Described operator()(const PeriodicCommand& command) const {
    return {"sampling", sampling_text(command.transducers, command.period_ms)};
  }
  Described operator()(const ActuateCommand& command) const {
    return {"actuate", fmt::format("actuator {} to {}", command.actuator, command.value)};
  }
  Described operator()(const MoteAck& ack) const {
    return {"acknowledge", fmt::format("message {}, status {}", ack.sequence, ack.status)};
  }
  Described operator()(const OtherRecord& other) const {
    return {"record", fmt::format("type {}, {} bytes", other.type, other.bytes.size())};
  }
};

PacketText describe_serial(const MotePacket& packet) {
  if (packet.is(AmType::kConfig)) {
    const auto config = decode_config(packet.payload);
    if (config && config->command == kSetIslandId)
      return {"config", {}, {}, fmt::format("the sink's island is {}", config->value)};
    return {"config",
            {},
            {},
            config ? fmt::format("command {}, value {}", config->command, config->value) : config.error().text};
  }
  return {"packet", {}, {}, fmt::format("AM type {:02x}, {} bytes", packet.am.type, packet.payload.size())};
}

}  // namespace

PacketText describe_packet(ByteView bytes) {
  const auto decoded = decode_whole(bytes);
  if (!decoded) return {"malformed", {}, {}, decoded.error().text};
  if (!decoded->radio) return describe_serial(decoded->packet);
  const auto& header = decoded->radio->header;
  auto [kind, text] = std::visit(Describe(), decoded->radio->record);
  return {kind, header.source_mote, header.destination_mote,
          fmt::format("{} -> {}: {}", header.source_mote, header.destination_mote, text)};
}

}  // namespace rubicon::motes
