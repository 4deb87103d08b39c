#include "networks/log/recorded_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>

#include "base/prefetch.h"
#include "model/point_keys.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::log {

namespace {

constexpr std::size_t kMaxNetworks = 1000;

/// `wsn-1.7.sensor.light-1.value` and `wsn-1.status`.
bool names_network(const std::vector<std::string_view>& parts) {
  if (parts.empty() || model::is_part_of_island(parts[0])) return false;
  if (parts.size() == 2) return parts[1] == "status";
  return parts.size() == 5 && (parts[2] == "sensor" || parts[2] == "actuator" || parts[2] == "property");
}

}  // namespace

bool RecordedNetworks::note(const std::vector<std::string_view>& parts) {
  if (!names_network(parts) || names_.contains(parts[0])) return false;
  if (names_.size() >= kMaxNetworks || parts[0] != model::to_key_part(parts[0])) return false;
  names_.emplace(parts[0]);
  return true;
}

Error RecordedNetworks::ambiguous() const {
  return {ErrorCode::kInvalid,
          fmt::format(
              "the recording holds the networks {}; choose one with the option `network`, for example `network: {}`",
              fmt::join(names_, ", "), *names_.begin())};
}

namespace {

std::optional<Kind> kind_from(std::string_view word) {
  for (const auto kind : {Kind::kSensor, Kind::kActuator, Kind::kProperty}) {
    if (word == to_string(kind)) return kind;
  }
  return std::nullopt;
}

/// Spares commands the search.
bool may_be_played(std::string_view key) {
  return key.ends_with(".value") || key.ends_with(".description") || key.ends_with(".status");
}

/// Never 0.
std::uint32_t hash_of(std::string_view key) {
  return static_cast<std::uint32_t>(std::uint64_t{std::hash<std::string_view>()(key)} >> 32) | 1U;
}

RecordedKeys::Role role_of_point(std::string_view last_part) {
  if (last_part == "value") return RecordedKeys::Role::kValue;
  if (last_part == "description") return RecordedKeys::Role::kPoint;
  if (last_part == "status") return RecordedKeys::Role::kStatus;
  return RecordedKeys::Role::kIgnored;
}

}  // namespace

RecordedKeys::RecordedKeys(std::string network, ForeignTypes& types, WorkBudget& budget, RecordingFaults& faults)
    : network_(std::move(network)),
      chosen_by_user_(!network_.empty()),
      types_(types),
      budget_(budget),
      faults_(faults) {}

bool RecordedKeys::read_head(const recording::FileHead& head) {
  prefix_ = head.prefix + ".";
  if (island_ == model::kNoOwner) island_ = head.island;
  return island_ == head.island;
}

bool RecordedKeys::is_of_island(const recording::Record& record) const {
  return record.owner == island_ && record.key.starts_with(prefix_);
}

void RecordedKeys::note_network(const recording::Record& record) {
  if (is_of_island(record)) networks_.note(model::key_parts(record.key.substr(prefix_.size())));
}

RecordedKeys::Numbered& RecordedKeys::numbered(const recording::Record& record) {
  if (record.key_number >= by_number_.size()) by_number_.resize(record.key_number + std::size_t{1});
  auto& numbered = by_number_[record.key_number];
  if (numbered.hash == 0) numbered.hash = hash_of(record.key);
  return numbered;
}

const RecordedKeys::Key* RecordedKeys::known(const Numbered& numbered, std::string_view text) const {
  const auto found = by_text_.find(numbered.hash, [&](std::uint32_t place) { return keys_[place].text == text; });
  return found == base::HashIndex::kNone ? nullptr : &keys_[found];
}

/// Each block names its keys again, in any order. So those of some records are looked for at once, one step of all
/// before the next step.
void RecordedKeys::fetch(std::span<const recording::Record> next) {
  for (const auto& record : next) by_text_.fetch(numbered(record).hash);
  for (const auto& record : next) {
    const auto guess = by_text_.guess(numbered(record).hash);
    if (guess != base::HashIndex::kNone) base::prefetch(&keys_[guess]);
  }
  for (const auto& record : next) {
    const auto guess = by_text_.guess(numbered(record).hash);
    if (guess == base::HashIndex::kNone) continue;
    const auto& text = keys_[guess].text;
    base::prefetch(text.data());
    base::prefetch(text.data() + text.size());
    if (const auto* device = keys_[guess].target.device) base::prefetch(device);
    if (const auto* point = keys_[guess].target.point) point->fetch();
  }
}

RecordedKeys::Target RecordedKeys::target_of(const recording::Record& record) {
  auto& numbered = this->numbered(record);
  auto& target = numbered.target;
  if (target.role != Role::kUnresolved) return target;
  target.role = Role::kIgnored;
  if (island_ == model::kNoOwner && model::is_island(record.owner)) island_ = record.owner;
  if (!is_of_island(record) || !may_be_played(record.key.substr(prefix_.size()))) return target;
  const auto* known = this->known(numbered, record.key);
  target = known ? known->target : add_key(record.key, numbered.hash);
  return target;
}

RecordedKeys::Target RecordedKeys::add_key(std::string_view key, std::uint32_t hash) {
  budget_.charge(4);
  if (by_text_.size() >= kMaxKeys || text_ + key.size() > kMaxText) {
    faults_.limit_exceeded("keys", by_text_.size());
    return {Role::kIgnored, nullptr, nullptr};
  }
  text_ += key.size();
  by_text_.add(hash, static_cast<std::uint32_t>(keys_.size()));
  return keys_.emplace_back(Key{std::string(key), resolve(key.substr(prefix_.size()))}).target;
}

/// `wsn-1.7.description`, `wsn-1.7.sensor.light-1.value` and so on, without the prefix.
RecordedKeys::Target RecordedKeys::resolve(std::string_view key) {
  constexpr Target kIgnored{Role::kIgnored, nullptr, nullptr};
  const auto parts = model::key_parts(key);
  if (networks_.note(parts) && network_.empty()) network_ = parts[0];
  const bool of_device = parts.size() == 3 && parts[2] == "description";
  const bool of_point = parts.size() == 5 && kind_from(parts[2]);
  if ((!of_device && !of_point) || parts[0] != network_) return kIgnored;
  const auto role = of_device ? Role::kDevice : role_of_point(parts.back());
  if (role == Role::kIgnored) return kIgnored;
  auto* device = find_or_add_device(parts[1]);
  if (device == nullptr) return kIgnored;
  if (of_device) return {Role::kDevice, device, nullptr};
  auto* point = find_or_add_point(*device, parts[2], parts[3]);
  return point == nullptr ? kIgnored : Target{role, device, point};
}

RecordedDevice* RecordedKeys::find_or_add_device(std::string_view id) {
  if (const auto found = devices_.find(id); found != devices_.end()) return found->second.get();
  if (devices_.size() >= kMaxDevices) {
    faults_.limit_exceeded("devices", kMaxDevices);
    return nullptr;
  }
  auto& device = *devices_.emplace(std::string(id), std::make_unique<RecordedDevice>()).first->second;
  device.id = id;
  return &device;
}

RecordedPoint* RecordedKeys::find_or_add_point(RecordedDevice& device, std::string_view kind, std::string_view id) {
  const RecordedDevice::PointKey key{*kind_from(kind), std::string(id)};
  if (const auto found = device.points.find(key); found != device.points.end()) return &found->second;
  if (device.points.size() >= kMaxPoints) {
    faults_.limit_exceeded("points of a device", kMaxPoints);
    return nullptr;
  }
  if (!types_.take_key_type(type_part(id))) {
    faults_.limit_exceeded("unknown types", ForeignTypes::kMaxInKeys);
    return nullptr;
  }
  auto& point = device.points[key];
  point.kind = key.first;
  point.id = id;
  point.type = types_.known(type_part(id));
  return &point;
}

}  // namespace rubicon::networks::log
