#include "motes/mote_codec.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::motes {

namespace {

constexpr std::uint16_t kFirstSpecialMote = kBaseMote;
constexpr std::uint16_t kFirstSpecialIsland = 0xfffd;

std::string name_of(std::uint16_t mote) {
  return fmt::format("{}", mote);
}

/// Every board declares type 1, so this is a claim, not a fact (wsn.md 6).
std::string model_of(std::uint8_t mote_type) {
  switch (mote_type) {
    case 1: return "TELOSB";
    case 2: return "IRIS";
    case 3: return "MICAZ";
    default: return fmt::format("mote type {}", mote_type);
  }
}

model::Message message_of(std::uint16_t mote, model::Body body) {
  model::Message message;
  message.source.device = name_of(mote);
  message.body = std::move(body);
  return message;
}

/// A message nobody here reads, with a tag by which its application finds it: `mote/<transport>/<application>/<type>`.
model::Opaque opaque_of(const NetMessage& message) {
  return {fmt::format("mote/{}/{}/{}", message.transport, message.application, message.record.front()),
          Bytes(message.record.begin(), message.record.end())};
}

RawUpdates updates_of(const DemoReport& demo) {
  return {{{static_cast<std::uint16_t>(Transducer::kLight), {demo.light}},
           {static_cast<std::uint16_t>(Transducer::kTemperature), {demo.temperature}}}};
}

std::optional<double> celsius_in(const RawUpdates& updates, const Calibration& calibration) {
  for (const RawReading& reading : updates.readings) {
    if (reading.transducer == static_cast<std::uint16_t>(Transducer::kTemperature))
      return temperature_of(reading.words.front(), calibration);
  }
  return std::nullopt;
}

bool has_point(const std::vector<model::Capability>& capabilities, const model::PointId& point) {
  return std::any_of(capabilities.begin(), capabilities.end(),
                     [&](const model::Capability& capability) { return capability.point == point; });
}

}  // namespace

MoteCodec::MoteCodec(const TypeCatalogue& types, Calibration calibration, std::optional<std::uint16_t> island)
    : types_(types), calibration_(calibration), island_(island) {}

Result<MoteEvents> MoteCodec::decode(ByteView bytes) {
  const auto packet = decode_packet(bytes);
  if (!packet) return fail(packet.error());
  MoteEvents events;
  if (!packet->is(AmType::kNetMessage)) {
    model::Message message;
    message.body = model::Opaque{fmt::format("mote/am/{}", packet->am.type),
                                 Bytes(packet->payload.begin(), packet->payload.end())};
    events.messages.push_back(std::move(message));
    return events;
  }
  const auto message = decode_net(packet->payload);
  if (!message) return fail(message.error());
  if (message->source_mote >= kFirstSpecialMote)
    return fail(ErrorCode::kInvalid, fmt::format("radio message from no mote ({:04x})", message->source_mote));
  const auto record = decode_record(*message);
  if (!record) return fail(record.error());

  const bool ours =
      !island_ || message->destination_island == *island_ || message->destination_island >= kFirstSpecialIsland;
  if (!ours) events.foreign_island = message->destination_island;
  if (ours && message->reliable == 1 && message->destination_mote == kBaseMote) events.wants_ack = message->sequence;
  on_record(*message, *record, events);
  return events;
}

void MoteCodec::on_record(const NetMessage& message, const Record& record, MoteEvents& events) {
  const std::uint16_t mote = message.source_mote;
  if (events.foreign_island) {
    // A join for another island tells of a sink with the wrong id; anything else is on its way there (wsn.md 9.1, 9.8).
    if (std::holds_alternative<Joined>(record)) return;
    model::Message out = message_of(mote, opaque_of(message));
    out.destination.island = IslandId{*events.foreign_island};
    if (message.destination_mote != kBaseMote) out.destination.device = name_of(message.destination_mote);
    events.messages.push_back(std::move(out));
  } else if (const auto* joined = std::get_if<Joined>(&record)) {
    on_joined(*joined, events);
  } else if (const auto* updates = std::get_if<RawUpdates>(&record)) {
    on_updates(mote, *updates, events);
  } else if (const auto* demo = std::get_if<DemoReport>(&record)) {
    on_updates(mote, updates_of(*demo), events);
  } else if (const auto* ack = std::get_if<MoteAck>(&record)) {
    events.ack = HeardAck{mote, message.application, *ack};
    heard(mote, events);
    // The sink itself is a device only when it sends readings (wsn.md 9.8).
    if (mote != kSinkMote) events.messages.push_back(message_of(mote, model::KeepAlive{}));
  } else {
    heard(mote, events);
    events.messages.push_back(message_of(mote, opaque_of(message)));
  }
}

void MoteCodec::on_joined(const Joined& joined, MoteEvents& events) {
  Mote& mote = motes_[joined.mote];
  mote.model = model_of(joined.mote_type);
  mote.declared.clear();
  for (const MoteSensor& sensor : sensors_in_mask(joined.transducers, calibration_))
    mote.declared.push_back(capability_of(sensor));
  constexpr std::pair<std::uint8_t, std::string_view> kActuators[] = {{0x01, "led"}, {0x02, "relay"}};
  for (const auto& [bit, type] : kActuators) {
    if ((joined.actuators & bit) == 0) continue;
    model::Capability capability;
    capability.point = point_of(Kind::kActuator, type, "1");
    capability.type_name = type;
    capability.access = model::Access::kWrite;
    capability.reports = false;
    mote.declared.push_back(std::move(capability));
  }
  tell_join(joined.mote, mote, events);
}

void MoteCodec::on_updates(std::uint16_t address, const RawUpdates& updates, MoteEvents& events) {
  bool grown = !motes_.contains(address);
  Mote& mote = motes_[address];
  if (const auto celsius = celsius_in(updates, calibration_)) mote.celsius = celsius;
  model::Updates out;
  for (const RawReading& reading : updates.readings) {
    for (const MoteSensor& sensor : sensors_of(reading.transducer, calibration_)) {
      if (sensor.word >= reading.words.size()) break;
      grown = show(mote, sensor) || grown;
      auto value = convert(sensor, reading.words[sensor.word], calibration_, mote.celsius);
      if (value) out.readings.push_back({point_of(Kind::kSensor, sensor.type, sensor.instance), std::move(*value), {}});
    }
  }
  if (grown) tell_join(address, mote, events);
  if (out.readings.empty()) {
    events.messages.push_back(message_of(address, model::KeepAlive{}));
  } else {
    events.messages.push_back(message_of(address, std::move(out)));
  }
}

void MoteCodec::heard(std::uint16_t address, MoteEvents& events) {
  if (address == kSinkMote || motes_.contains(address)) return;
  tell_join(address, motes_[address], events);
}

void MoteCodec::tell_join(std::uint16_t address, const Mote& mote, MoteEvents& events) const {
  model::Join join;
  join.device_type = "mote";
  join.model = mote.model;
  join.capabilities = mote.declared;
  for (const model::Capability& capability : mote.shown) {
    if (!has_point(join.capabilities, capability.point)) join.capabilities.push_back(capability);
  }
  events.messages.push_back(message_of(address, std::move(join)));
}

bool MoteCodec::show(Mote& mote, const MoteSensor& sensor) const {
  model::Capability capability = capability_of(sensor);
  if (has_point(mote.declared, capability.point) || has_point(mote.shown, capability.point)) return false;
  mote.shown.push_back(std::move(capability));
  return true;
}

model::Capability MoteCodec::capability_of(const MoteSensor& sensor) const {
  model::Capability capability;
  capability.point = point_of(Kind::kSensor, sensor.type, sensor.instance);
  capability.type_name = sensor.type;
  return capability;
}

model::PointId MoteCodec::point_of(Kind kind, std::string_view type, std::string instance) const {
  const Type* known = types_.find(type);
  return {kind, known != nullptr ? known->id : TypeId{}, std::move(instance)};
}

}  // namespace rubicon::motes
