#include "networks/log/tuple_recording.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "model/key.h"

namespace rubicon::networks::log {

using recording::Record;
using recording::RecordKind;

namespace {

/// What a hostile recording may make us remember.
constexpr std::size_t kMaxKeys = 1'000'000;
constexpr std::size_t kMaxNetworks = 1000;
/// Messages and readings of one step.
constexpr std::size_t kMaxSaid = 500;
/// A snapshot whose end got lost ends after this.
constexpr Duration kLongestSnapshot = std::chrono::minutes(1);

bool is_gone(const Record& record) {
  return record.kind == RecordKind::kDeleted || record.kind == RecordKind::kExpired;
}

std::optional<Kind> kind_called(std::string_view word) {
  for (const auto kind : {Kind::kSensor, Kind::kActuator, Kind::kProperty}) {
    if (word == to_string(kind)) return kind;
  }
  return std::nullopt;
}

/// Most keys are those of statuses: they need not be looked up.
bool is_of_interest(std::string_view key) {
  if (key.ends_with(".value") || key.ends_with(".description")) return true;
  const auto dot = key.find('.');  // that of a network names it
  return dot != key.npos && key.substr(dot) == ".status";
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
  reader_ = recording::RecordingReader();
  places_.clear();
  kept_.reset();
}

/// What was told in the round before counts no longer; the devices stay until the recording says they are not there.
void TupleRecording::restart() {
  for (auto& [id, device] : devices_) {
    for (auto& [key, point] : device->points) {
      point.sequence = 0;
      point.write_time = {};
    }
  }
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

/// One step holds what was seen in one turn of the recorded loop.
std::optional<Step> TupleRecording::next() {
  step_ = {};
  while (auto record = kept_ ? std::exchange(kept_, std::nullopt) : next_record()) {
    const RecordTime time = record->seen.time_since_epoch();
    const bool same = step_.said.empty() || (step_.time == time && step_.said.size() < kMaxSaid);
    if (!same) {
      kept_ = record;
      return std::move(step_);
    }
    step_.time = time;
    if (record->seen != turn_ && !in_snapshot_) settle();
    turn_ = record->seen;
    ++counters_.records;
    take(*record);
  }
  if (failure_) return std::nullopt;
  if (reader_.ended()) settle();
  if (step_.said.empty()) return std::nullopt;
  return std::move(step_);
}

std::optional<Record> TupleRecording::next_record() {
  while (!failure_) {
    auto item = reader_.next();
    if (!item) return std::nullopt;
    if (auto* record = std::get_if<Record>(&*item)) return *record;
    if (const auto* head = std::get_if<recording::FileHead>(&*item)) on_head(*head);
    if (std::holds_alternative<recording::BlockFound>(*item)) on_block();
    if (const auto* damage = std::get_if<recording::Damage>(&*item)) on_damage(*damage);
  }
  return std::nullopt;
}

void TupleRecording::on_head(const recording::FileHead& head) {
  prefix_ = head.prefix + ".";
  if (island_ == model::kNobody) island_ = head.island;
  if (island_ == head.island) return;
  complain_(0, fmt::format("is of island {}, the files before are of island {}; not played", number(head.island),
                           number(island_)));
}

void TupleRecording::on_block() {
  places_.clear();
  if (std::exchange(looked_ahead_, true) || chosen_by_user_) return;
  // A recorder begins with all that is there: the first block names the networks.
  auto records = reader_.block();
  while (const auto record = records.next()) place_of(*record);
  places_.clear();
}

void TupleRecording::on_damage(const recording::Damage& damage) {
  ++counters_.damaged;
  counters_.skipped_bytes += damage.bytes;
  snapshot_is_sound_ = false;
  complain_(damage.offset, fmt::format("{}; {} bytes skipped", damage.why, damage.bytes));
}

void TupleRecording::bad(std::string text) {
  ++counters_.damaged;
  complain_(reader_.block_offset(), text);
}

TupleRecording::Place TupleRecording::place_of(const Record& record) {
  if (record.key_number >= places_.size()) places_.resize(record.key_number + std::size_t{1});
  auto& place = places_[record.key_number];
  if (place.role != Role::kUnknown) return place;
  place.role = Role::kOther;
  if (island_ == model::kNobody && model::is_island(record.owner)) island_ = record.owner;
  if (record.owner != island_ || !record.key.starts_with(prefix_)) return place;
  if (!is_of_interest(record.key.substr(prefix_.size()))) return place;
  if (const auto known = keys_.find(record.key); known != keys_.end()) return place = known->second;
  const auto found = resolve(record.key.substr(prefix_.size()));
  if (keys_.size() < kMaxKeys) keys_.emplace(record.key, found);
  return places_[record.key_number] = found;
}

/// `wsn-1.7.sensor.light-1.value` and so on; what is neither description nor value says nothing.
TupleRecording::Place TupleRecording::resolve(std::string_view key) {
  const auto parts = model::key_parts(key);
  const bool of_point = parts.size() == 5 && kind_called(parts[2]);
  if (of_point || (parts.size() == 2 && parts[1] == "status")) note_network(parts[0]);
  if (parts.size() < 3 || parts[0] != network_ || keys_.size() >= kMaxKeys) return {Role::kOther, nullptr, nullptr};
  if (parts.size() == 3 && parts[2] == "description") return {Role::kDevice, device_called(parts[1]), nullptr};
  if (!of_point || (parts[4] != "value" && parts[4] != "description")) return {Role::kOther, nullptr, nullptr};
  auto* device = device_called(parts[1]);
  auto* point = point_called(*device, parts[2], parts[3]);
  return {parts[4] == "value" ? Role::kValue : Role::kPoint, device, point};
}

void TupleRecording::note_network(std::string_view name) {
  if (networks_.contains(name) || networks_.size() >= kMaxNetworks || name != model::to_key_part(name)) return;
  networks_.emplace(name);
  if (chosen_by_user_) return;
  if (network_.empty()) network_ = name;
  if (networks_.size() > 1) {
    failure_ = Error{ErrorCode::kInvalid, fmt::format("the recording holds the networks {}; say which one to play, "
                                                      "for example network: {}",
                                                      fmt::join(networks_, ", "), *networks_.begin())};
  }
}

RecordedDevice* TupleRecording::device_called(std::string_view id) {
  auto found = devices_.find(id);
  if (found == devices_.end()) {
    found = devices_.emplace(std::string(id), std::make_unique<RecordedDevice>()).first;
    found->second->id = id;
  }
  return found->second.get();
}

RecordedPoint* TupleRecording::point_called(RecordedDevice& device, std::string_view kind, std::string_view id) {
  const auto [found, fresh] = device.points.try_emplace({*kind_called(kind), std::string(id)});
  auto& point = found->second;
  if (fresh) {
    point.kind = found->first.first;
    point.id = id;
    point.type = types_.known(type_part(id));
  }
  return &point;
}

void TupleRecording::take(const Record& record) {
  if (record.kind == RecordKind::kMark) return on_mark(record);
  if (in_snapshot_ && record.seen - snapshot_since_ > kLongestSnapshot) in_snapshot_ = false;
  const auto place = place_of(record);
  if (place.device == nullptr) return;
  place.device->confirmed = snapshot_;
  switch (place.role) {
    case Role::kDevice: return on_device(*place.device, record);
    case Role::kPoint: return on_point(*place.device, *place.point, record);
    case Role::kValue: return on_value(*place.device, *place.point, record);
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
  settle();
  if (!snapshot_is_sound_) return;
  for (auto& [id, device] : devices_) {
    if (device->joined() && device->confirmed != snapshot_) leave(*device, "the recording begins anew without it");
  }
}

void TupleRecording::on_device(RecordedDevice& device, const Record& record) {
  if (is_gone(record)) return leave(device, "it left the recorded network");
  if (device.text == record.value) {
    if (device.changed) look_later(device);
  } else if (describe(device, record.value)) {
    device.changed = true;
  } else {
    return bad(fmt::format("{} is no description of a device", model::quoted(record.key)));
  }
  if (!device.joined() || device.changed) device.complete() ? join(device) : look_later(device);
}

void TupleRecording::on_point(RecordedDevice& device, RecordedPoint& point, const Record& record) {
  if (is_gone(record)) {
    point.text.clear();
    return;
  }
  if (point.text == record.value) return;
  if (!describe(point, record.value, types_))
    return bad(fmt::format("{} is no description of a point", model::quoted(record.key)));
  device.changed = true;
  // A join that changes something describes its points first and the device last.
  if (!device.joined() && device.complete()) return join(device);
  look_later(device);
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
    if (point.joined && device.joined()) return tell(device, point, std::move(*value), record.user_time);
    point.waiting = model::Reading{{}, std::move(*value), record.user_time};
  }
  if (!point.joined) look_later(device);
}

void TupleRecording::look_later(RecordedDevice& device) {
  if (std::exchange(device.queued, true)) return;
  unsettled_.push_back(&device);
}

/// At the end of a turn: whoever is not described by now is shown by what is known of it.
void TupleRecording::settle() {
  for (auto* device : std::exchange(unsettled_, {})) {
    device->queued = false;
    const bool lacks = std::any_of(device->points.begin(), device->points.end(),
                                   [](const auto& one) { return one.second.alive && !one.second.joined; });
    if (device->changed || lacks) join(*device);
  }
}

void TupleRecording::join(RecordedDevice& device) {
  const auto address = device.address.empty() ? device.id : device.address;
  if (device.joined() && device.joined_as != address) leave(device, "it has another address");
  auto told = join_of(device, types_);
  step_.said.emplace_back(address, std::move(told));
  device.joined_as = address;
  device.changed = false;
  for (auto& [key, point] : device.points) {
    if (!point.joined || !point.waiting) continue;
    auto reading = *std::exchange(point.waiting, std::nullopt);
    tell(device, point, std::move(reading.value), reading.user_time);
  }
}

void TupleRecording::leave(RecordedDevice& device, std::string reason) {
  if (device.joined()) step_.said.emplace_back(std::exchange(device.joined_as, {}), model::Leave{std::move(reason)});
  device.text.clear();
  device.listed = {};
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
  last->readings.push_back({point.capability.point, std::move(value), user_time});
}

}  // namespace rubicon::networks::log
