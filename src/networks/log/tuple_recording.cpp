#include "networks/log/tuple_recording.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/key.h"

namespace rubicon::networks::log {

using recording::Record;
using recording::RecordKind;

namespace {

/// Messages of a step, and readings of a message.
constexpr std::size_t kMaxSaid = 250;
/// What others wait for, in small records of about 100 ns.
constexpr std::size_t kShare = 10'000;
/// Bytes that take as long as a small record: to be moved, and to be parsed.
constexpr std::size_t kCopied = 256, kParsed = 16;
/// Records of the first block that name the networks; the recorder's own blocks have fewer.
constexpr std::size_t kLookAhead = 50'000;
/// Values that wait for the end of a turn or snapshot, in bytes; more end it.
constexpr std::size_t kMaxHeld = 8 << 20;
/// A snapshot whose end got lost ends after this.
constexpr RecordTime kLongestSnapshot = std::chrono::minutes(1);

bool is_gone(const Record& record) {
  return record.kind == RecordKind::kDeleted || record.kind == RecordKind::kExpired;
}

std::optional<Kind> kind_called(std::string_view word) {
  for (const auto kind : {Kind::kSensor, Kind::kActuator, Kind::kProperty}) {
    if (word == to_string(kind)) return kind;
  }
  return std::nullopt;
}

/// Commands need not be looked up.
bool is_of_interest(std::string_view key) {
  return key.ends_with(".value") || key.ends_with(".description") || key.ends_with(".status");
}

std::size_t size_of(const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return text->size();
  const auto* json = std::get_if<Json>(&value);
  return json == nullptr ? 0 : json->text.size();
}

}  // namespace

TupleRecording::TupleRecording(const TypeCatalogue& types, std::string network, ReplayCounters& counters,
                               Complaint complain)
    : types_(types),
      network_(std::move(network)),
      counters_(counters),
      complain_(std::move(complain)),
      chosen_by_user_(!network_.empty()) {}

void TupleRecording::begin(std::string_view, std::vector<std::string>) {
  reader_ = recording::RecordingReader(kReaderShare);
  places_.clear();
  kept_.reset();
}

/// What was told in the round before counts no longer; the devices stay until the recording says they are not there.
void TupleRecording::restart() {
  ++session_;
  in_snapshot_ = false;
}

void TupleRecording::end() {
  reader_.end();
}

std::vector<std::string> TupleRecording::devices() const {
  std::vector<std::string> joined;
  for (const auto& [id, device] : devices_) {
    if (device->joined()) joined.push_back(device->joined_as);
  }
  return joined;
}

/// A step holds what was seen in one turn of the recorded loop, or a part of it.
std::optional<Step> TupleRecording::next() {
  step_ = {};
  has_more_ = !go_on();
  if (failure_ || step_.said.empty()) {
    if (has_more_) work_ = 0;
    return std::nullopt;
  }
  return std::move(step_);
}

/// Until there is nothing to go on with; false when there is enough for now.
bool TupleRecording::go_on() {
  while (!failure_) {
    if (naming_) return go_on_naming();
    if (!do_chores() || spent()) return false;
    auto record = kept_ ? std::exchange(kept_, std::nullopt) : next_record();
    if (!record) {
      if (reader_.busy() || spent()) return false;
      if (!reader_.ended() || unsettled_.empty()) return true;
      settling_ = true;
      continue;
    }
    if (record->seen != turn_ && !unsettled_.empty() && !in_snapshot_) {
      settling_ = true;
      kept_ = record;
      continue;
    }
    const RecordTime time = record->seen.time_since_epoch();
    if (!step_.said.empty() && step_.time != time) {
      kept_ = record;
      return false;
    }
    step_.time = time;
    turn_ = record->seen;
    ++counters_.records;
    take(*record);
  }
  return true;
}

/// To the end of the file: a network may have come late.
bool TupleRecording::go_on_naming() {
  step_ = {};
  while (const auto record = next_record()) {
    if (record->owner != island_ || !record->key.starts_with(prefix_)) continue;
    networks_.note(model::key_parts(record->key.substr(prefix_.size())));
  }
  if (reader_.busy() || spent()) return false;
  if (!reader_.ended()) return true;
  failure_ = networks_.choose();
  return true;
}

bool TupleRecording::spent() const {
  return work_ >= kShare || step_.said.size() >= kMaxSaid;
}

/// What concerns many devices goes on from call to call; false while there is some of it.
bool TupleRecording::do_chores() {
  if (settling_ || !missing_.empty()) step_.time = turn_.time_since_epoch();
  while (settling_ && !unsettled_.empty()) {
    if (spent()) return false;
    auto* device = unsettled_.front();
    unsettled_.pop_front();
    settle(*device);
  }
  if (std::exchange(settling_, false)) held_ = 0;
  if (std::exchange(completing_, false)) {
    work_ += devices_.size();
    for (auto& [id, device] : devices_) {
      if (device->joined() && device->confirmed != snapshot_) missing_.push_back(device.get());
    }
  }
  while (!missing_.empty()) {
    if (spent()) return false;
    leave(*missing_.front(), "the recording begins anew without it");
    missing_.pop_front();
  }
  return true;
}

std::optional<Record> TupleRecording::next_record() {
  while (!failure_) {
    if (work_ >= kShare) return std::nullopt;
    auto item = reader_.next();
    if (!item) return std::nullopt;
    if (auto* record = std::get_if<Record>(&*item)) {
      work_ += 1 + record->value.size() / kCopied;
      return *record;
    }
    if (const auto* head = std::get_if<recording::FileHead>(&*item)) on_head(*head);
    if (std::holds_alternative<recording::BlockFound>(*item)) on_block();
    if (const auto* damage = std::get_if<recording::Damage>(&*item)) on_damage(*damage);
  }
  return std::nullopt;
}

void TupleRecording::on_head(const recording::FileHead& head) {
  ++work_;
  head_read_ = true;
  prefix_ = head.prefix + ".";
  if (island_ == model::kNoOwner) island_ = head.island;
  if (island_ == head.island) return;
  complain_(0, fmt::format("is of island {}, the files before are of island {}; not played", number(head.island),
                           number(island_)));
}

void TupleRecording::on_block() {
  work_ += recording::kBlockSize / kCopied;
  places_.clear();
  head_read_ = true;  // or lost
  if (std::exchange(looked_ahead_, true) || chosen_by_user_) return;
  // A recorder begins with all that is there: the first block names the networks.
  auto records = reader_.block();
  for (std::size_t i = 0; i < kLookAhead; ++i) {
    const auto record = records.next();
    if (!record) break;
    place_of(*record);
  }
  places_.clear();
  work_ += kShare;
}

void TupleRecording::on_damage(const recording::Damage& damage) {
  work_ += 1 + static_cast<std::size_t>(damage.bytes) / kCopied;
  ++counters_.damaged;
  counters_.skipped_bytes += damage.bytes;
  snapshot_is_sound_ = false;
  complain_(damage.offset, fmt::format("{}; {} bytes skipped", damage.why, damage.bytes));
}

void TupleRecording::bad(const std::string& text) {
  ++counters_.damaged;
  complain_(reader_.block_offset(), text);
}

TupleRecording::Place TupleRecording::place_of(const Record& record) {
  if (record.key_number >= places_.size()) places_.resize(record.key_number + std::size_t{1});
  auto& place = places_[record.key_number];
  if (place.role != Role::kUnknown) return place;
  place.role = Role::kOther;
  if (island_ == model::kNoOwner && model::is_island(record.owner)) island_ = record.owner;
  if (record.owner != island_ || !record.key.starts_with(prefix_)) return place;
  if (!is_of_interest(record.key.substr(prefix_.size()))) return place;
  if (const auto known = keys_.find(record.key); known != keys_.end()) return place = known->second;
  const auto found = remember(record.key);
  return places_[record.key_number] = found;
}

TupleRecording::Place TupleRecording::remember(std::string_view key) {
  work_ += 4;
  if (keys_.size() >= kMaxKeys || key_text_ + key.size() > kMaxText) {
    too_many("keys", keys_.size());
    return {Role::kOther, nullptr, nullptr};
  }
  key_text_ += key.size();
  return keys_.emplace(key, resolve(key.substr(prefix_.size()))).first->second;
}

void TupleRecording::too_many(std::string_view what, std::size_t bound) {
  if (bounds_told_.contains(what)) return;
  bounds_told_.emplace(what);
  bad(fmt::format("more {} than are played, expected at most {}; the others are passed over", what, bound));
}

bool TupleRecording::take_room(std::size_t before, std::size_t after) {
  if (described_ - before + after > kMaxText) return false;
  described_ = described_ - before + after;
  return true;
}

/// `wsn-1.7.sensor.light-1.value` and so on; what is neither description nor value says nothing.
TupleRecording::Place TupleRecording::resolve(std::string_view key) {
  const auto parts = model::key_parts(key);
  const bool of_point = parts.size() == 5 && kind_called(parts[2]);
  if (networks_.note(parts)) choose_network(parts[0]);
  constexpr Place kNothing{Role::kOther, nullptr, nullptr};
  const bool of_device = parts.size() == 3 && parts[2] == "description";
  if (parts.size() < 3 || parts[0] != network_ || (!of_device && !of_point)) return kNothing;
  const auto role = parts.back() == "value"         ? Role::kValue
                    : parts.back() == "description" ? Role::kPoint
                    : parts.back() == "status"      ? Role::kStatus
                                                    : Role::kOther;
  if (role == Role::kOther) return kNothing;
  auto* device = device_called(parts[1]);
  if (device == nullptr) return kNothing;
  if (of_device) return {Role::kDevice, device, nullptr};
  auto* point = point_called(*device, parts[2], parts[3]);
  return point == nullptr ? kNothing : Place{role, device, point};
}

RecordedDevice* TupleRecording::device_called(std::string_view id) {
  auto found = devices_.find(id);
  if (found == devices_.end()) {
    if (devices_.size() >= kMaxDevices) return too_many("devices", kMaxDevices), nullptr;
    found = devices_.emplace(std::string(id), std::make_unique<RecordedDevice>()).first;
    found->second->id = id;
  }
  return found->second.get();
}

RecordedPoint* TupleRecording::point_called(RecordedDevice& device, std::string_view kind, std::string_view id) {
  const RecordedDevice::PointKey key{*kind_called(kind), std::string(id)};
  if (const auto found = device.points.find(key); found != device.points.end()) return &found->second;
  if (device.points.size() >= kMaxPoints) return too_many("points of a device", kMaxPoints), nullptr;
  if (!types_.take_key_type(type_part(id))) return too_many("unknown types", ForeignTypes::kMaxInKeys), nullptr;
  auto& point = device.points[key];
  point.kind = key.first;
  point.id = id;
  point.type = types_.known(type_part(id));
  return &point;
}

void TupleRecording::take(const Record& record) {
  if (record.kind == RecordKind::kMark) return on_mark(record);
  if (in_snapshot_ && record.seen - snapshot_since_ > kLongestSnapshot) in_snapshot_ = false;
  const auto place = place_of(record);
  if (place.device == nullptr) return;
  place.device->confirmed = snapshot_;
  if (place.point != nullptr) begin_session(*place.point);
  switch (place.role) {
    case Role::kDevice: return on_device(*place.device, record);
    case Role::kPoint: return on_point(*place.device, *place.point, record);
    case Role::kValue: return on_value(*place.device, *place.point, record);
    case Role::kStatus: return on_status(*place.device, *place.point, record);
    case Role::kUnknown:
    case Role::kOther: return;
  }
}

void TupleRecording::on_mark(const Record& record) {
  if (record.value == recording::kMarkComplete) return snapshot_complete();
  const bool start = record.value == recording::kMarkStart;
  if (!start && record.value != recording::kMarkSnapshot) return;
  if (start) restart();
  ++snapshot_;
  in_snapshot_ = snapshot_is_sound_ = true;
  snapshot_since_ = record.seen;
}

void TupleRecording::snapshot_complete() {
  if (!std::exchange(in_snapshot_, false)) return;
  settling_ = true;
  completing_ = snapshot_is_sound_;
}

void TupleRecording::on_device(RecordedDevice& device, const Record& record) {
  if (is_gone(record)) return leave(device, "it left the recorded network");
  if (device.text == record.value) {
    if (device.changed) look_later(device);
  } else {
    work_ += record.value.size() / kParsed + device.points.size();
    const auto before = device.text_cost();
    if (record.value.size() > kMaxDescription || !describe(device, record.value)) {
      return bad(fmt::format("{} is no description of a device, expected a JSON object of at most {} bytes",
                             model::quoted(record.key), kMaxDescription));
    }
    if (!take_room(before, device.text_cost())) {
      described_ -= before;
      for (auto* text : {&device.text, &device.address, &device.name, &device.model, &device.type}) text->clear();
      device.listed = {};
      device.capabilities.clear();
      return too_many("bytes of descriptions", kMaxText);
    }
    device.changed = true;
  }
  if (!device.joined() || device.changed) device.complete() && !in_snapshot_ ? join(device) : look_later(device);
}

void TupleRecording::on_point(RecordedDevice& device, RecordedPoint& point, const Record& record) {
  if (is_gone(record)) {
    described_ -= point.text.size();
    point.text.clear();
    return;
  }
  if (point.text == record.value) return;
  work_ += record.value.size() / kParsed;
  const auto before = point.text.size();
  if (record.value.size() > kMaxDescription || !take_room(before, record.value.size()))
    return too_many("bytes of descriptions", kMaxText);
  if (!describe(point, record.value, types_)) {
    described_ -= record.value.size() - before;
    return bad(
        fmt::format("{} is no description of a point, expected a JSON object with a type", model::quoted(record.key)));
  }
  device.changed = true;
  work_ += device.listed[0].size() + device.listed[1].size() + device.listed[2].size();
  // A join that changes something describes its points first and the device last.
  if (!device.joined() && device.complete() && !in_snapshot_) return join(device);
  look_later(device);
}

void TupleRecording::begin_session(RecordedPoint& point) const {
  if (std::exchange(point.session, session_) == session_) return;
  point.sequence = 0;
  point.write_time = {};
  point.status.reset();
}

void TupleRecording::on_value(RecordedDevice& device, RecordedPoint& point, const Record& record) {
  if (is_gone(record)) {
    point.alive = point.joined = false;
    point.sequence = 0;
    point.write_time = {};
    point.waiting.reset();
    const bool all =
        std::none_of(device.points.begin(), device.points.end(), [](auto& one) { return one.second.alive; });
    if (all && device.text.empty()) leave(device, "its values left the recorded network");
    return;
  }
  if (record.sequence <= point.sequence && record.write_time <= point.write_time) return;  // told already
  point.sequence = record.sequence;
  point.write_time = record.write_time;
  point.alive = true;
  const auto* type = point.type;
  const bool text = type == nullptr || type->data == model::DataType::kText || type->data == model::DataType::kBytes;
  // Tuples are made empty, before there is a value.
  if (!record.value.empty() || (text && record.sequence > 1)) {
    auto value = recorded_value(type, record.value, record.media_type);
    if (!value) return bad(fmt::format("{}: {}", model::quoted(record.key), value.error().text));
    if (must_wait(device, point)) return hold(device, point, std::move(*value), record);
    return tell(device, point, std::move(*value), record.user_time);
  }
  if (!point.joined) look_later(device);
}

/// A value that an island remembered from before its start says so in its status, right behind it.
bool TupleRecording::must_wait(const RecordedDevice& device, const RecordedPoint& point) const {
  if (!point.joined || !device.joined()) return true;
  return point.status ? !point.status->is_live() : in_snapshot_;
}

void TupleRecording::hold(RecordedDevice& device, RecordedPoint& point, Value value, const Record& record) {
  tell_held(device, point);
  const bool is_stored =
      record.kind == RecordKind::kPresent && point.status && !point.status->is_heard(record.write_time);
  held_ += size_of(value);
  if (held_ > kMaxHeld) settling_ = true;
  if (!is_stored) point.waiting = model::Reading{{}, std::move(value), record.user_time};
  look_later(device);
}

void TupleRecording::tell_held(RecordedDevice& device, RecordedPoint& point) {
  if (!point.waiting || !point.joined || !device.joined()) return;
  auto reading = *std::exchange(point.waiting, std::nullopt);
  tell(device, point, std::move(reading.value), reading.user_time);
}

void TupleRecording::on_status(RecordedDevice& device, RecordedPoint& point, const Record& record) {
  point.status = is_gone(record) ? std::nullopt : recorded_status(record.value);
  if (!point.waiting || !point.status) return;
  if (!point.status->is_heard(point.write_time)) {
    point.waiting.reset();
  } else {
    tell_held(device, point);
  }
}

void TupleRecording::look_later(RecordedDevice& device) {
  if (std::exchange(device.queued, true)) return;
  unsettled_.push_back(&device);
}

/// At the end of a turn: whoever is not described by now is shown by what is known of it.
void TupleRecording::settle(RecordedDevice& device) {
  device.queued = false;
  work_ += 1 + device.points.size() / 8;
  const bool lacks = std::any_of(device.points.begin(), device.points.end(),
                                 [](const auto& one) { return one.second.alive && !one.second.joined; });
  if (device.changed || lacks) return join(device);
  for (auto& [key, point] : device.points) tell_held(device, point);
}

void TupleRecording::join(RecordedDevice& device) {
  const auto address = device.address.empty() ? device.id : device.address;
  if (device.joined() && device.joined_as != address) leave(device, "it has another address");
  work_ += 10 * (1 + device.points.size());
  auto told = join_of(device, types_);
  step_.said.emplace_back(address, std::move(told));
  device.joined_as = address;
  device.changed = false;
  for (auto& [key, point] : device.points) tell_held(device, point);
}

void TupleRecording::leave(RecordedDevice& device, std::string reason) {
  if (device.joined()) step_.said.emplace_back(std::exchange(device.joined_as, {}), model::Leave{std::move(reason)});
  described_ -= device.text_cost();
  work_ += 1 + device.points.size() / 8;
  device.text.clear();
  device.listed = {};
  device.capabilities.clear();
  device.changed = false;
  for (auto& [key, point] : device.points) {
    point.alive = point.joined = false;
    point.waiting.reset();
    point.capability.initial = {};
  }
}

void TupleRecording::tell(RecordedDevice& device, RecordedPoint& point, Value value, WallTime user_time) {
  auto& said = step_.said;
  auto* last = said.empty() || said.back().first != device.joined_as ? nullptr
                                                                     : std::get_if<model::Updates>(&said.back().second);
  const bool of_device = point.kind == Kind::kProperty;
  // Properties are told apart: they count where readings are passed over.
  if (last != nullptr &&
      (last->readings.size() >= kMaxSaid || (last->readings.front().point.kind == Kind::kProperty) != of_device))
    last = nullptr;
  if (last == nullptr) last = &std::get<model::Updates>(said.emplace_back(device.joined_as, model::Updates{}).second);
  last->readings.push_back({point.capability.point, in_unit_of_type(point, std::move(value)), user_time});
}

}  // namespace rubicon::networks::log
