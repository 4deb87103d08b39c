#include "networks/log/device_replay.h"

#include <algorithm>

#include "rubicon/key.hpp"

namespace rubicon::networks::log {

using recording::Record;
using recording::RecordKind;

namespace {

/// Messages of a step, and readings of a message.
constexpr std::size_t kMaxMessages = 250;
/// Values held until the end of a turn or snapshot, in bytes; more end the turn.
constexpr std::size_t kMaxHeld = 8 << 20;
/// A snapshot whose end was lost ends after this.
constexpr RecordTime kMaxSnapshot = std::chrono::minutes(1);

bool is_removal(const Record& record) {
  return record.kind == RecordKind::kDeleted || record.kind == RecordKind::kExpired;
}

std::size_t text_size(const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return text->size();
  const auto* json = std::get_if<Json>(&value);
  return json == nullptr ? 0 : json->text.size();
}

bool holds_text(const Type* type) {
  return type == nullptr || type->data == model::DataType::kText || type->data == model::DataType::kBytes;
}

}  // namespace

bool DeviceReplay::budget_used() const {
  return budget_.used_up() || step_.messages.size() >= kMaxMessages;
}

void DeviceReplay::begin_session() {
  ++session_;
  in_snapshot_ = false;
}

bool DeviceReplay::run_pending() {
  if (turn_ended_ || !missing_.empty()) step_.time = turn_.time_since_epoch();
  while (turn_ended_ && !deferred_.empty()) {
    if (budget_used()) return false;
    auto* device = deferred_.front();
    deferred_.pop_front();
    settle(*device);
  }
  if (std::exchange(turn_ended_, false)) held_bytes_ = 0;
  if (std::exchange(find_missing_, false)) find_missing();
  while (!missing_.empty()) {
    if (budget_used()) return false;
    leave(*missing_.front(), "missing in the next snapshot of the recording");
    missing_.pop_front();
  }
  return true;
}

void DeviceReplay::find_missing() {
  budget_.charge(keys_.devices().size());
  for (const auto& [id, device] : keys_.devices()) {
    if (device->joined() && device->confirmed != snapshot_) missing_.push_back(device.get());
  }
}

void DeviceReplay::play(const Record& record) {
  turn_ = record.seen;
  if (record.kind == RecordKind::kMark) return read_mark(record);
  if (in_snapshot_ && record.seen - snapshot_since_ > kMaxSnapshot) in_snapshot_ = false;
  const auto target = keys_.target_of(record);
  if (target.device == nullptr) return;
  target.device->confirmed = snapshot_;
  if (target.point != nullptr) update_session(*target.point);
  switch (target.role) {
    case RecordedKeys::Role::kDevice: return read_device(*target.device, record);
    case RecordedKeys::Role::kPoint: return read_point(*target.device, *target.point, record);
    case RecordedKeys::Role::kValue: return read_value(*target.device, *target.point, record);
    case RecordedKeys::Role::kStatus: return read_status(*target.device, *target.point, record);
    case RecordedKeys::Role::kUnresolved:
    case RecordedKeys::Role::kIgnored: return;
  }
}

void DeviceReplay::read_mark(const Record& record) {
  if (record.value == recording::kMarkComplete) return complete_snapshot();
  const bool start = record.value == recording::kMarkStart;
  if (!start && record.value != recording::kMarkSnapshot) return;
  if (start) begin_session();
  ++snapshot_;
  in_snapshot_ = snapshot_is_sound_ = true;
  snapshot_since_ = record.seen;
}

void DeviceReplay::complete_snapshot() {
  if (!std::exchange(in_snapshot_, false)) return;
  turn_ended_ = true;
  find_missing_ = snapshot_is_sound_;
}

void DeviceReplay::update_session(RecordedPoint& point) const {
  if (std::exchange(point.session, session_) == session_) return;
  point.sequence = 0;
  point.write_time = {};
  point.status.reset();
}

void DeviceReplay::read_device(RecordedDevice& device, const Record& record) {
  if (is_removal(record)) return leave(device, "it left the recorded network");
  if (device.text == record.value) {
    if (device.changed) defer(device);
  } else {
    budget_.charge_parsed(record.value.size());
    budget_.charge(device.points.size());
    const auto before = device.text_cost();
    if (record.value.size() > kMaxDescription || !describe(device, record.value)) {
      return faults_.invalid(
          fmt::format("{} is not a description of a device, expected a JSON object of at most {} bytes",
                      model::quoted(record.key), kMaxDescription));
    }
    if (!reserve_description(before, device.text_cost())) return drop_description(device, before);
    device.changed = true;
  }
  if (!device.joined() || device.changed) join_or_defer(device);
}

void DeviceReplay::drop_description(RecordedDevice& device, std::size_t counted) {
  description_bytes_ -= counted;
  for (auto* text : {&device.text, &device.address, &device.name, &device.model, &device.type}) text->clear();
  device.listed = {};
  device.capabilities.clear();
  faults_.limit_exceeded("bytes of descriptions", kMaxDescriptions);
}

bool DeviceReplay::reserve_description(std::size_t before, std::size_t after) {
  if (description_bytes_ - before + after > kMaxDescriptions) return false;
  description_bytes_ = description_bytes_ - before + after;
  return true;
}

void DeviceReplay::join_or_defer(RecordedDevice& device) {
  if (device.complete() && !in_snapshot_) {
    join(device);
  } else {
    defer(device);
  }
}

void DeviceReplay::read_point(RecordedDevice& device, RecordedPoint& point, const Record& record) {
  if (is_removal(record)) {
    description_bytes_ -= point.text.size();
    point.text.clear();
    return;
  }
  if (point.text == record.value) return;
  budget_.charge_parsed(record.value.size());
  const auto before = point.text.size();
  if (record.value.size() > kMaxDescription || !reserve_description(before, record.value.size()))
    return faults_.limit_exceeded("bytes of descriptions", kMaxDescriptions);
  if (!describe(point, record.value, types_, descriptions_)) {
    description_bytes_ -= record.value.size() - before;
    return faults_.invalid(fmt::format("{} is not a description of a point, expected a JSON object with a type",
                                       model::quoted(record.key)));
  }
  device.changed = true;
  for (const auto& ids : device.listed) budget_.charge(ids.size());
  // A join that changes something describes its points first and the device last.
  if (!device.joined()) return join_or_defer(device);
  defer(device);
}

void DeviceReplay::read_value(RecordedDevice& device, RecordedPoint& point, const Record& record) {
  if (is_removal(record)) return remove_value(device, point);
  if (record.sequence <= point.sequence && record.write_time <= point.write_time) return;  // played before
  point.sequence = record.sequence;
  point.write_time = record.write_time;
  point.alive = true;
  // A proxy creates its tuples empty, before there is a value.
  if (record.value.empty() && (!holds_text(point.type) || record.sequence <= 1)) {
    if (!point.joined) defer(device);
    return;
  }
  auto value = recorded_value(point.type, record.value, record.media_type);
  if (!value) return faults_.invalid(fmt::format("{}: {}", model::quoted(record.key), value.error().text));
  if (must_hold(device, point)) return hold(device, point, std::move(*value), record);
  add_reading(device, point, std::move(*value), record.user_time);
}

void DeviceReplay::remove_value(RecordedDevice& device, RecordedPoint& point) {
  point.alive = point.joined = false;
  point.sequence = 0;
  point.write_time = {};
  point.waiting.reset();
  const bool none_left =
      std::none_of(device.points.begin(), device.points.end(), [](auto& one) { return one.second.alive; });
  if (none_left && device.text.empty()) leave(device, "its values left the recorded network");
}

/// The status, which follows its value, shows whether an island had that value from before its start.
bool DeviceReplay::must_hold(const RecordedDevice& device, const RecordedPoint& point) const {
  if (!point.joined || !device.joined()) return true;
  return point.status ? !point.status->is_live() : in_snapshot_;
}

void DeviceReplay::hold(RecordedDevice& device, RecordedPoint& point, Value value, const Record& record) {
  release(device, point);
  const bool is_stored =
      record.kind == RecordKind::kPresent && point.status && !point.status->is_heard(record.write_time);
  held_bytes_ += text_size(value);
  if (held_bytes_ > kMaxHeld) end_turn();
  if (!is_stored)
    point.waiting = std::make_unique<model::Reading>(model::Reading{{}, std::move(value), record.user_time});
  defer(device);
}

void DeviceReplay::release(RecordedDevice& device, RecordedPoint& point) {
  if (!point.waiting || !point.joined || !device.joined()) return;
  auto reading = std::move(point.waiting);
  add_reading(device, point, std::move(reading->value), reading->user_time);
}

void DeviceReplay::read_status(RecordedDevice& device, RecordedPoint& point, const Record& record) {
  point.status = is_removal(record) ? std::nullopt : recorded_status(record.value);
  if (!point.waiting || !point.status) return;
  if (point.status->is_heard(point.write_time)) {
    release(device, point);
  } else {
    point.waiting.reset();
  }
}

void DeviceReplay::defer(RecordedDevice& device) {
  if (!std::exchange(device.deferred, true)) deferred_.push_back(&device);
}

/// Points that have no description by the end of the turn join with what is known of them.
void DeviceReplay::settle(RecordedDevice& device) {
  device.deferred = false;
  budget_.charge(1 + device.points.size() / 8);
  const bool lacks_points = std::any_of(device.points.begin(), device.points.end(),
                                        [](const auto& one) { return one.second.alive && !one.second.joined; });
  if (device.changed || lacks_points) return join(device);
  for (auto& [key, point] : device.points) release(device, point);
}

void DeviceReplay::join(RecordedDevice& device) {
  const auto address = device.address.empty() ? device.id : device.address;
  if (device.joined() && device.joined_as != address) leave(device, "it has another address");
  budget_.charge(10 * (1 + device.points.size()));
  step_.messages.emplace_back(address, join_of(device, types_));
  device.joined_as = address;
  device.changed = false;
  for (auto& [key, point] : device.points) release(device, point);
}

void DeviceReplay::leave(RecordedDevice& device, std::string reason) {
  if (device.joined())
    step_.messages.emplace_back(std::exchange(device.joined_as, {}), model::Leave{std::move(reason)});
  description_bytes_ -= device.text_cost();
  budget_.charge(1 + device.points.size() / 8);
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

/// The message that readings of this kind go to. Properties go apart: `start` plays them where it skips readings.
model::Updates& DeviceReplay::updates_for(const RecordedDevice& device, Kind kind) {
  auto& messages = step_.messages;
  if (!messages.empty() && messages.back().first == device.joined_as) {
    auto* last = std::get_if<model::Updates>(&messages.back().second);
    const auto is_property = [](Kind one) { return one == Kind::kProperty; };
    if (last != nullptr && last->readings.size() < kMaxMessages &&
        is_property(last->readings.front().point.kind) == is_property(kind))
      return *last;
  }
  return std::get<model::Updates>(messages.emplace_back(device.joined_as, model::Updates{}).second);
}

void DeviceReplay::add_reading(RecordedDevice& device, RecordedPoint& point, Value value, WallTime user_time) {
  updates_for(device, point.kind)
      .readings.push_back({point.capability.point, in_unit_of_type(point, std::move(value)), user_time});
}

}  // namespace rubicon::networks::log
