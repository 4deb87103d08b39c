#include "motes/mote_records.h"

#include <fmt/format.h>

#include <optional>

namespace rubicon::motes {

namespace {

// Record types (wsn.md 6 and 7.1).
constexpr std::uint8_t kPeriodicType = 0x01;
constexpr std::uint8_t kActuateType = 0x02;
constexpr std::uint8_t kJoinedType = 0x10;
constexpr std::uint8_t kAckType = 0x17;
constexpr std::uint8_t kDemoType = 0x22;
constexpr std::uint8_t kUpdatesType = 0x23;
constexpr std::uint8_t kReadUpdatesType = 0x24;
constexpr std::size_t kDemoFieldsUnused = 7;

bool known_transducer(std::uint16_t id) {
  constexpr std::uint16_t kLast = static_cast<std::uint16_t>(Transducer::kRssi5);
  return id != 0 && id <= kLast && (id & (id - 1)) == 0;
}

/// Decodes the items of an Updates record in one of two ways; false if they exceed the frame.
bool read_items(ByteView items, std::size_t count, bool multi_valued, RawUpdates& updates, bool& found_unknown) {
  base::ByteReader reader(items);
  std::size_t words_left = kMaxUpdateWords;
  for (std::size_t i = 0; i < count; ++i) {
    RawReading reading{reader.u16_be(), {}};
    found_unknown = found_unknown || !known_transducer(reading.transducer);
    const std::size_t words = multi_valued ? words_of(reading.transducer) : 1;
    if (!reader.ok() || words + 1 > words_left) return false;
    words_left -= words + 1;
    for (std::size_t w = 0; w < words; ++w) reading.words.push_back(reader.u16_be());
    if (!reader.ok()) return false;
    updates.readings.push_back(reading);
  }
  return true;
}

Result<Record> cut_short(std::string_view what, std::size_t size) {
  return fail(ErrorCode::kInvalid, fmt::format("mote record {} cut short after {} bytes", what, size));
}

Result<Record> decode_updates(ByteView record) {
  if (record.size() < 2) return cut_short("UPDATES", record.size());
  const ByteView items = record.subspan(2);
  Record record_read{std::in_place_type<RawUpdates>};
  RawUpdates& updates = std::get<RawUpdates>(record_read);
  bool found_unknown = false;
  bool whole = read_items(items, record[1], true, updates, found_unknown);
  // Multi-valued items are documented but were never seen: an unknown id may be a value taken for an id (wsn.md 7.1).
  if (found_unknown) {
    bool still_unknown = false;
    RawUpdates single;
    if (read_items(items, record[1], false, single, still_unknown) && !still_unknown) {
      updates = single;
      whole = true;
    }
  }
  if (!whole) return cut_short("UPDATES", record.size());
  return record_read;
}

Result<Record> decode_joined(ByteView record) {
  base::ByteReader reader(record.subspan(1));
  Joined joined;
  joined.island = reader.u16_be();
  joined.mote = reader.u16_be();
  joined.mote_type = reader.u8();
  joined.transducers = reader.u16_be();
  joined.actuators = reader.u8();
  if (!reader.ok()) return cut_short("SERIAL_JOINED", record.size());
  return Record(joined);
}

Result<Record> decode_demo(ByteView record) {
  base::ByteReader reader(record.subspan(1));
  DemoReport demo;
  demo.light = reader.u16_be();
  demo.temperature = reader.u16_be();
  reader.skip(kDemoFieldsUnused * 2);
  if (!reader.ok()) return cut_short("DEMO_DATA", record.size());
  return Record(demo);
}

Result<Record> decode_read_updates(ByteView record) {
  base::ByteReader reader(record.subspan(1));
  ReadUpdates read;
  read.period_ms = reader.u16_be();
  read.transducers = reader.u16_be();
  if (!reader.ok()) return cut_short("READ_UPDATES", record.size());
  return Record(read);
}

Result<Record> decode_periodic(ByteView record) {
  base::ByteReader reader(record.subspan(1));
  PeriodicCommand periodic;
  periodic.transducers = reader.u16_be();
  periodic.period_ms = reader.u16_be();
  if (!reader.ok()) return cut_short("periodic command", record.size());
  return Record(periodic);
}

Result<Record> decode_actuate(ByteView record) {
  base::ByteReader reader(record.subspan(1));
  ActuateCommand actuate;
  actuate.actuator = reader.u16_be();
  actuate.value = static_cast<std::int32_t>(reader.u32_be());
  if (!reader.ok()) return cut_short("actuate command", record.size());
  return Record(actuate);
}

Result<Record> decode_ack(ByteView record) {
  base::ByteReader reader(record.subspan(1));
  MoteAck ack;
  ack.sequence = reader.u16_be();
  ack.status = reader.u8();
  if (!reader.ok()) return cut_short("acknowledgement", record.size());
  return Record(ack);
}

struct RecordForm {
  std::uint8_t transport;
  std::uint8_t application;  ///< 0 = any
  std::uint8_t type;
  Result<Record> (*decode)(ByteView);
};

constexpr RecordForm kForms[] = {
    {kTransportConnectionless, kApplicationControl, kJoinedType, decode_joined},
    {kTransportConnectionless, kApplicationControl, kUpdatesType, decode_updates},
    {kTransportConnectionless, kApplicationMockup, kDemoType, decode_demo},
    {kTransportConnectionless, kApplicationControl, kReadUpdatesType, decode_read_updates},
    {kTransportConnectionless, kApplicationMockup, kReadUpdatesType, decode_read_updates},
    {kTransportConnectionless, kApplicationMockup, kPeriodicType, decode_periodic},
    {kTransportConnectionless, kApplicationMockup, kActuateType, decode_actuate},
    {kTransportAck, 0, kAckType, decode_ack},
};

void write(base::ByteWriter& out, const Joined& r) {
  out.u8(kJoinedType).u16_be(r.island).u16_be(r.mote).u8(r.mote_type).u16_be(r.transducers).u8(r.actuators);
}
void write(base::ByteWriter& out, const RawUpdates& r) {
  out.u8(kUpdatesType).u8(static_cast<std::uint8_t>(r.readings.size()));
  for (const RawReading& reading : r.readings) {
    out.u16_be(reading.transducer);
    for (const std::uint16_t word : reading.words) out.u16_be(word);
  }
}
void write(base::ByteWriter& out, const DemoReport& r) {
  out.u8(kDemoType).u16_be(r.light).u16_be(r.temperature).bytes(Bytes(kDemoFieldsUnused * 2, 0));
}
void write(base::ByteWriter& out, const ReadUpdates& r) {
  out.u8(kReadUpdatesType).u16_be(r.period_ms).u16_be(r.transducers);
}
void write(base::ByteWriter& out, const PeriodicCommand& r) {
  out.u8(kPeriodicType).u16_be(r.transducers).u16_be(r.period_ms);
}
void write(base::ByteWriter& out, const ActuateCommand& r) {
  out.u8(kActuateType).u16_be(r.actuator).u32_be(static_cast<std::uint32_t>(r.value));
}
void write(base::ByteWriter& out, const MoteAck& r) {
  out.u8(kAckType).u16_be(r.sequence).u8(r.status);
}
void write(base::ByteWriter& out, const OtherRecord& r) {
  out.bytes(r.bytes);
}

}  // namespace

std::size_t words_of(std::uint16_t transducer) {
  switch (static_cast<Transducer>(transducer)) {
    case Transducer::kAccelerationX:
    case Transducer::kAccelerationY: return 2;
    case Transducer::kRssi1: return 5;
    default: return 1;
  }
}

Result<Record> decode_record(const NetMessage& message) {
  if (message.record.empty()) return fail(ErrorCode::kInvalid, "mote record without a type byte");
  const std::uint8_t type = message.record.front();
  for (const RecordForm& form : kForms) {
    const bool application_fits = form.application == 0 || form.application == message.application;
    if (form.transport == message.transport && application_fits && form.type == type)
      return form.decode(message.record);
  }
  return Record(OtherRecord{type, message.record});
}

Result<DecodedPacket> decode_whole(ByteView bytes) {
  const auto packet = decode_packet(bytes);
  if (!packet) return fail(packet.error());
  Result<DecodedPacket> decoded(DecodedPacket{*packet, std::nullopt});
  if (!packet->is(AmType::kNetMessage)) return decoded;
  const auto header = decode_net(packet->payload);
  if (!header) return fail(header.error());
  auto record = decode_record(*header);
  if (!record) return fail(record.error());
  decoded->radio.emplace(RadioMessage{*header, std::move(*record)});
  return decoded;
}

Bytes encode_record(const Record& record) {
  base::ByteWriter writer;
  std::visit([&writer](const auto& alternative) { write(writer, alternative); }, record);
  return writer.take();
}

Result<ConfigCommand> decode_config(ByteView payload) {
  base::ByteReader reader(payload);
  ConfigCommand command;
  command.command = reader.u8();
  command.value = reader.u16_be();
  if (!reader.ok())
    return fail(ErrorCode::kInvalid, fmt::format("sink configuration of {} bytes, expected 3", payload.size()));
  return command;
}

Bytes encode_config(const ConfigCommand& command) {
  base::ByteWriter writer;
  writer.u8(command.command).u16_be(command.value);
  return writer.take();
}

}  // namespace rubicon::motes
