#include "motes/packet_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <utility>
#include <vector>

#include "motes/mote_records.h"

namespace rubicon::motes {

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
