#include "motes/mote_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace rubicon::motes {

namespace {

constexpr std::uint16_t kFirstSpecialMote = kBaseMote;
constexpr std::uint16_t kFirstSpecialIsland = 0xfffd;
constexpr std::size_t kBoards = 5, kUnits = 3;
/// Bits of the actuator mask (wsn.md 6).
constexpr std::pair<std::uint8_t, std::string_view> kActuators[] = {{0x01, "led"}, {0x02, "relay"}};

std::string name_of(std::uint16_t mote) {
  return fmt::format("{}", mote);
}

/// As declared, which proves little: every board declares type 1 (wsn.md 6).
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

/// A message for an application, tagged `mote/<transport>/<application>/<type>`. `forwarded` to another island it keeps
/// what the receiver needs to acknowledge it: `.../reliable/<sequence>`.
model::Opaque opaque_of(const NetMessage& message, bool forwarded) {
  auto tag = fmt::format("mote/{}/{}/{}", message.transport, message.application, message.record.front());
  if (forwarded && message.reliable == 1) tag += fmt::format("/reliable/{}", message.sequence);
  return {std::move(tag), Bytes(message.record.begin(), message.record.end())};
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

MoteCodec::MoteCodec(const TypeCatalogue& types, CodecOptions options) : types_(types) {
  std::ignore = change(std::move(options));
}

std::vector<model::Message> MoteCodec::change(CodecOptions options) {
  options_ = std::move(options);
  exceptions_.clear();
  for (const auto& [mote, board] : options_.boards) {
    exceptions_[mote] = options_.calibration;
    exceptions_[mote].board = board;
  }
  std::vector<model::Message> joins;
  for (auto& [address, mote] : motes_) {
    mote.shown.clear();
    if (mote.joined) declare(address, mote);
    joins.push_back(join_of(address, mote));
  }
  return joins;
}

const Calibration& MoteCodec::calibration(std::uint16_t mote) const {
  const auto own = exceptions_.find(mote);
  return own == exceptions_.end() ? options_.calibration : own->second;
}

Result<MoteEvents> MoteCodec::decode(ByteView bytes) {
  const auto decoded = decode_whole(bytes);
  if (!decoded) return fail(decoded.error());
  return interpret(*decoded);
}

Result<MoteEvents> MoteCodec::interpret(const DecodedPacket& decoded) {
  MoteEvents events;
  if (!decoded.radio) {
    const auto& [am, payload] = decoded.packet;
    model::Message message;
    message.body = model::Opaque{fmt::format("mote/am/{}", am.type), Bytes(payload.begin(), payload.end())};
    events.messages.push_back(std::move(message));
    return events;
  }
  const auto& [message, record] = *decoded.radio;
  if (message.source_mote >= kFirstSpecialMote)
    return fail(ErrorCode::kInvalid, fmt::format("radio message from address {:04x}, expected a mote's (below {:04x})",
                                                 message.source_mote, kFirstSpecialMote));
  const bool is_full = motes_.size() >= kMaxMotes && !motes_.contains(message.source_mote);
  if (is_full && !std::holds_alternative<Joined>(record))
    return fail(ErrorCode::kBusy, fmt::format("mote {} ignored: {} motes are known, more than a sink has",
                                              message.source_mote, kMaxMotes));
  on_record(message, record, events);
  return events;
}

void MoteCodec::on_record(const NetMessage& message, const Record& record, MoteEvents& events) {
  const auto& own = options_.island;
  const std::uint16_t mote = message.source_mote;
  const bool for_us = !own || message.destination_island == *own;
  if (for_us || message.destination_island >= kFirstSpecialIsland) {
    if (own && message.source_island != *own && message.source_island < kFirstSpecialIsland) {
      events.foreign_source = message.source_island;
      return;
    }
    events.mote = mote;
    if (for_us && message.reliable == 1 && message.destination_mote == kBaseMote)
      events.wants_ack = WantedAck{mote, message.application, message.sequence};
    return on_own_record(message, record, events);
  }
  events.foreign_island = message.destination_island;
  if (message.source_island != *own) return;
  events.mote = mote;
  sign_of_life(mote, events);
  events.messages.push_back(message_of(mote, model::KeepAlive{}));
  // It may acknowledge a request from that island which we sent to the mote, and whose result we await.
  if (const auto* ack = std::get_if<MoteAck>(&record)) events.ack = HeardAck{mote, message.application, *ack};
  model::Message out = message_of(mote, opaque_of(message, true));
  out.destination.island = IslandId{message.destination_island};
  if (message.destination_mote != kBaseMote) out.destination.device = name_of(message.destination_mote);
  events.messages.push_back(std::move(out));
}

void MoteCodec::on_own_record(const NetMessage& message, const Record& record, MoteEvents& events) {
  const std::uint16_t mote = message.source_mote;
  if (const auto* joined = std::get_if<Joined>(&record)) {
    on_joined(*joined, events);
  } else if (const auto* updates = std::get_if<RawUpdates>(&record)) {
    on_updates(mote, *updates, events);
  } else if (const auto* demo = std::get_if<DemoReport>(&record)) {
    on_updates(mote, updates_of(mote, *demo), events);
  } else if (const auto* ack = std::get_if<MoteAck>(&record)) {
    events.ack = HeardAck{mote, message.application, *ack};
    sign_of_life(mote, events);
    // The sink itself is a device only when it sends readings (wsn.md 9.8).
    if (mote != kSinkMote || motes_.contains(mote)) events.messages.push_back(message_of(mote, model::KeepAlive{}));
  } else {
    sign_of_life(mote, events);
    events.messages.push_back(message_of(mote, opaque_of(message, false)));
  }
}

void MoteCodec::on_joined(const Joined& joined, MoteEvents& events) {
  if (joined.mote >= kFirstSpecialMote) return;
  Mote& mote = heard(joined.mote);
  mote.joined = joined;
  mote.model = model_of(joined.mote_type);
  mote.fields.reset();
  declare(joined.mote, mote);
  events.mote = joined.mote;
  events.joined = true;
  report_join(joined.mote, mote, events);
}

const MoteCodec::Shared& MoteCodec::nothing() {
  static const Shared none = std::make_shared<const Capabilities>();
  return none;
}

/// Motes of one kind declare the same, and there may be thousands: they share one copy.
MoteCodec::Shared MoteCodec::shared(Capabilities capabilities) {
  std::erase_if(kinds_, [](const auto& kind) { return kind.expired(); });
  for (const auto& kind : kinds_) {
    if (auto known = kind.lock(); known && *known == capabilities) return known;
  }
  auto fresh = std::make_shared<const Capabilities>(std::move(capabilities));
  if (kinds_.size() < kMaxKinds) kinds_.push_back(fresh);
  return fresh;
}

void MoteCodec::declare(std::uint16_t address, Mote& mote) {
  Capabilities declared;
  for (const MoteSensor& sensor : sensors_in_mask(mote.joined->transducers, calibration(address)))
    declared.push_back(capability_of(sensor));
  for (const auto& [bit, type] : kActuators) {
    if ((mote.joined->actuators & bit) != 0) declared.push_back(actuator(type));
  }
  mote.declared = shared(std::move(declared));
}

model::Capability MoteCodec::actuator(std::string_view type) const {
  model::Capability capability;
  capability.point = point_of(Kind::kActuator, type, "1");
  capability.type_name = type;
  capability.access = model::Access::kReadWrite;
  capability.reports = options_.actuators_report;
  return capability;
}

/// The mask that a mote declared, reconstructed from its remembered sensors under any board and units.
std::uint16_t MoteCodec::mask_of(std::uint16_t address, const model::Join& join) const {
  std::uint16_t mask = 0;
  for (const model::Capability& known : join.capabilities) {
    std::uint16_t found = transducer_under(calibration(address), known.point);
    for (std::size_t form = 0; form < kBoards * kUnits && found == 0; ++form)
      found = transducer_under({static_cast<Board>(form % kBoards), static_cast<Units>(form / kBoards)}, known.point);
    mask |= found;
  }
  return mask;
}

std::optional<model::Message> MoteCodec::remember(std::uint16_t address, const model::Join& join) {
  if (motes_.size() >= kMaxMotes && !motes_.contains(address)) return std::nullopt;
  Mote& mote = motes_[address];
  if (mote.joined) return std::nullopt;
  Joined joined{0, address, 0, mask_of(address, join), 0};
  for (const auto& [bit, type] : kActuators) {
    if (has_point(join.capabilities, point_of(Kind::kActuator, type, "1"))) joined.actuators |= bit;
  }
  mote.joined = joined;
  mote.model = join.model;
  declare(address, mote);
  auto message = join_of(address, mote);
  const auto& now = std::get<model::Join>(message.body).capabilities;
  const auto same = [&](const model::Capability& one) {
    return one.point.kind == Kind::kProperty || std::find(now.begin(), now.end(), one) != now.end();
  };
  const auto& before = join.capabilities;
  const auto properties =
      std::count_if(before.begin(), before.end(), [](const auto& one) { return one.point.kind == Kind::kProperty; });
  const bool as_remembered = before.size() == now.size() + static_cast<std::size_t>(properties) &&
                             std::all_of(before.begin(), before.end(), same);
  if (as_remembered && mote.heard == 0) return std::nullopt;
  return message;
}

void MoteCodec::set_measured(std::uint16_t mote, std::optional<MeasuredFields> fields) {
  if (const auto found = motes_.find(mote); found != motes_.end()) found->second.fields = fields;
}

bool MoteCodec::offers(std::uint16_t mote, const model::PointId& point) const {
  const auto found = motes_.find(mote);
  return found != motes_.end() && (has_point(*found->second.declared, point) || has_point(found->second.shown, point));
}

std::uint16_t MoteCodec::transducer_of(std::uint16_t mote, const model::PointId& point) const {
  return transducer_under(calibration(mote), point);
}

std::uint16_t MoteCodec::transducer_under(const Calibration& calibration, const model::PointId& point) const {
  for (unsigned bit = 1; bit <= static_cast<unsigned>(Transducer::kRssi5); bit <<= 1U) {
    for (const MoteSensor& sensor : sensors_of(static_cast<std::uint16_t>(bit), calibration)) {
      if (point_of(Kind::kSensor, sensor.type, sensor.instance) == point) return sensor.transducer;
    }
  }
  return 0;
}

/// The measured ones of the two fields that the firmware fills.
RawUpdates MoteCodec::updates_of(std::uint16_t address, const DemoReport& demo) const {
  const auto mote = motes_.find(address);
  const auto fields = mote == motes_.end() ? options_.unknown : mote->second.fields.value_or(options_.unknown);
  RawUpdates updates;
  for (const auto& [transducer, word] :
       {std::pair(Transducer::kLight, demo.light), std::pair(Transducer::kTemperature, demo.temperature)}) {
    const auto id = static_cast<std::uint16_t>(transducer);
    const bool measured = (fields.sure & id) != 0 || ((fields.unless_zero & id) != 0 && word != 0);
    if (measured) updates.readings.push_back({id, {word}});
  }
  return updates;
}

void MoteCodec::on_updates(std::uint16_t address, const RawUpdates& updates, MoteEvents& events) {
  bool grown = !motes_.contains(address);
  Mote& mote = heard(address);
  const Calibration& units = calibration(address);
  events.reported = true;
  if (const auto celsius = celsius_in(updates, units)) mote.celsius = celsius;
  model::Updates out;
  for (const RawReading& reading : updates.readings) {
    for (const MoteSensor& sensor : sensors_of(reading.transducer, units)) {
      if (sensor.word >= reading.words.size()) break;
      grown = show(mote, sensor) || grown;
      auto value = convert(sensor, reading.words[sensor.word], units, mote.celsius);
      if (value) out.readings.push_back({point_of(Kind::kSensor, sensor.type, sensor.instance), std::move(*value), {}});
    }
  }
  if (grown) report_join(address, mote, events);
  if (out.readings.empty()) {
    events.messages.push_back(message_of(address, model::KeepAlive{}));
  } else {
    events.messages.push_back(message_of(address, std::move(out)));
  }
}

MoteCodec::Mote& MoteCodec::heard(std::uint16_t address) {
  if (motes_.size() >= kMaxMotes && !motes_.contains(address)) forget_one();
  Mote& mote = motes_[address];
  mote.heard = ++last_heard_;
  return mote;
}

/// Only one that joins makes it necessary. Radio noise does not join, and a mote that was replaced is silent.
void MoteCodec::forget_one() {
  const auto rank = [](const auto& one) { return std::pair(one.second.joined.has_value(), one.second.heard); };
  motes_.erase(std::min_element(motes_.begin(), motes_.end(),
                                [&](const auto& one, const auto& other) { return rank(one) < rank(other); }));
}

void MoteCodec::sign_of_life(std::uint16_t address, MoteEvents& events) {
  const bool fresh = !motes_.contains(address);
  if (fresh && address == kSinkMote) return;
  const Mote& mote = heard(address);
  if (fresh) report_join(address, mote, events);
}

void MoteCodec::report_join(std::uint16_t address, const Mote& mote, MoteEvents& events) const {
  events.messages.push_back(join_of(address, mote));
}

model::Message MoteCodec::join_of(std::uint16_t address, const Mote& mote) const {
  model::Join join;
  join.device_type = "mote";
  join.model = mote.model;
  join.capabilities = *mote.declared;
  join.heard = mote.heard != 0;
  for (const model::Capability& capability : mote.shown) {
    if (!has_point(join.capabilities, capability.point)) join.capabilities.push_back(capability);
  }
  return message_of(address, std::move(join));
}

bool MoteCodec::show(Mote& mote, const MoteSensor& sensor) const {
  model::Capability capability = capability_of(sensor);
  if (has_point(*mote.declared, capability.point) || has_point(mote.shown, capability.point)) return false;
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
