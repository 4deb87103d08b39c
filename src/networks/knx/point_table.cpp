#include "networks/knx/point_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "networks/knx/wire/cemi.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx {

namespace {

/// Added to the period of cyclic reads: a value is stale when the answer to the next read is overdue.
constexpr Duration kAnswerTime = std::chrono::seconds(10);

std::string address_of(const groups::GroupPoint& group) {
  return group.device.empty() ? to_string(group.address) : group.device;
}

TypeId type_of(const groups::GroupPoint& group, const dpt::Dpt* dpt, const TypeCatalogue& types) {
  if (group.scenes) return groups::kNamedScene;
  if (dpt) return group.kind == Kind::kSensor ? dpt->sensor : dpt->actuator;
  return types.find(group.kind == Kind::kSensor ? "bytesInput" : "bytesOutput")->id;
}

/// Bounds beyond this only tell what the number format can hold (floats, 64 bit), nothing about the point.
constexpr double kNoBound = 1e15;

/// Sets the bounds of the data point type in the catalogue's unit where they are narrower than those of the catalogue's
/// type. The range of a 16 bit float bounds commands only: measured values have the same range in every network.
void add_range(Capability& capability, const dpt::Dpt& dpt, const model::Type& type) {
  const bool numeric = type.data == model::DataType::kReal || type.data == model::DataType::kInteger ||
                       type.data == model::DataType::kEnumeration;
  const auto range = numeric ? dpt::range_of(dpt) : std::nullopt;
  if (!range) return;
  const bool commanded = capability.point.kind == Kind::kActuator;
  const bool meaningful = commanded || dpt.form != dpt::Form::kFloat16;
  if (range->minimum > type.minimum && range->minimum > -kNoBound && (commanded || std::isinf(type.minimum)) &&
      meaningful)
    capability.minimum = range->minimum;
  if (range->maximum < type.maximum && range->maximum < kNoBound && (commanded || std::isinf(type.maximum)) &&
      meaningful)
    capability.maximum = range->maximum;
}

/// A device is in the room of its points, if that is one.
void place(PointTable::Device& device, const std::string& room) {
  if (room.empty() || device.several_rooms) return;
  device.several_rooms = !device.room.empty() && device.room != room;
  device.room = device.several_rooms ? std::string() : room;
}

Capability capability_of(const BoundPoint& point, const TypeCatalogue& types) {
  Capability capability;
  capability.point = point.id;
  if (point.dpt) {
    const auto& type = *types.find(point.id.type);
    add_range(capability, *point.dpt, type);
    if (type.words.empty()) capability.words = words_of(*point.dpt);
  }
  if (point.scenes) {
    capability.words = *point.scenes;
    capability.minimum = 1;
    capability.maximum = groups::most_scene_number(point.dpt->id);
  }
  const bool actuator = point.id.kind == Kind::kActuator;
  capability.access = actuator ? model::Access::kReadWrite : model::Access::kRead;
  capability.reports = point.readable();
  capability.sampled = actuator && point.readable();
  const auto& rule = point.group.read;
  const bool periodic = rule.when == groups::ReadRule::When::kEvery || rule.when == groups::ReadRule::When::kExpire;
  capability.deadline = periodic ? rule.period + kAnswerTime : Duration::zero();  // the bus reports changes only
  return capability;
}

}  // namespace

PointTable::PointTable(const std::vector<groups::GroupPoint>& groups, const TypeCatalogue& types,
                       wire::Notation notation)
    : types_(&types), notation_(notation) {
  points_.reserve(groups.size());
  for (const auto& group : groups) bind(group, types);
  sort();
  std::set<std::string> taken;
  for (const auto& group : groups) {
    if (!group.device.empty()) taken.insert(model::to_key_part(group.device));
  }
  // A device that is called `1.4.6` and the group address 1/4/6 would have one key (knx.md, section 1).
  for (const auto& group : groups) {
    const auto key = wire::to_key_part(group.address);
    if (group.device.empty() && taken.contains(key)) wanted_ids_[address_of(group)] = "ga-" + key;
  }
}

void PointTable::bind(const groups::GroupPoint& group, const TypeCatalogue& types) {
  BoundPoint point;
  point.group = {group.address, group.state, group.dpt, group.name, group.state_name, group.read};
  point.dpt = group.dpt ? dpt::find_dpt(*group.dpt) : nullptr;
  point.id = {group.kind, type_of(group, point.dpt, types), group.instance};
  point.address = address_of(group);
  if (group.scenes && point.dpt)
    point.scenes = std::make_shared<const std::vector<model::Word>>(groups::scene_words(point.dpt->id, *group.scenes));
  const auto index = points_.size();
  auto& device = devices_[point.address];
  device.points.push_back(index);
  if (device.name.empty() && !group.device.empty()) device.name = group.device_name;
  place(device, group.room);
  const auto listen = [&](wire::GroupAddress address) {
    listeners_.push_back({address, static_cast<std::uint32_t>(index)});
  };
  listen(point.source());
  for (const auto address : group.listen) listen(address);
  if (group.state) command_addresses_.push_back(group.address);
  points_.push_back(std::move(point));
}

void PointTable::sort() {
  const auto order = [](const Listener& one) { return std::pair(number(one.address), one.point); };
  std::sort(listeners_.begin(), listeners_.end(), [&](const auto& a, const auto& b) { return order(a) < order(b); });
  const auto same = std::unique(listeners_.begin(), listeners_.end(),
                                [&](const auto& a, const auto& b) { return order(a) == order(b); });
  listeners_.erase(same, listeners_.end());
  listeners_.shrink_to_fit();
  std::sort(command_addresses_.begin(), command_addresses_.end());
  command_addresses_.shrink_to_fit();
}

std::span<const PointTable::Listener> PointTable::listeners_of(wire::GroupAddress address) const {
  struct ByAddress {
    bool operator()(const Listener& one, wire::GroupAddress wanted) const { return one.address < wanted; }
    bool operator()(wire::GroupAddress wanted, const Listener& one) const { return wanted < one.address; }
  };
  const auto [first, last] = std::equal_range(listeners_.begin(), listeners_.end(), address, ByAddress());
  return {first, last};
}

bool PointTable::contains(wire::GroupAddress address) const {
  return !listeners_of(address).empty() ||
         std::binary_search(command_addresses_.begin(), command_addresses_.end(), address);
}

const BoundPoint* PointTable::commanded_by(wire::GroupAddress address) const {
  for (const auto& listener : listeners_of(address)) {
    const auto& point = points_[listener.point];
    if (point.id.kind == Kind::kActuator && point.group.state != address) return &point;
  }
  for (const auto& point : points_) {
    if (point.id.kind == Kind::kActuator && point.group.address == address) return &point;
  }
  return nullptr;
}

std::string PointTable::command_at(wire::GroupAddress address) const {
  const auto* point = commanded_by(address);
  if (!point) return {};
  return fmt::format("actuator.{}-{}.command of device {}", types_->find(point->id.type)->name, point->id.instance,
                     point->address);
}

BoundPoint* PointTable::find(const std::string& device, const PointId& id) {
  const auto found = devices_.find(device);
  if (found == devices_.end()) return nullptr;
  for (const auto index : found->second.points) {
    if (points_[index].id == id) return &points_[index];
  }
  return nullptr;
}

/// `KNX 1/0/1, state 1/0/2, DPT 1.001`: all points of the device, cut after 200 characters.
std::string PointTable::model_of(const Device& device) const {
  constexpr std::size_t kMaxLength = 200;
  std::string text = "KNX";
  for (const auto index : device.points) {
    const auto& group = points_[index].group;
    text += fmt::format("{} {}", index == device.points.front() ? "" : ";", to_string(group.address, notation_));
    if (group.state) text += ", state " + to_string(*group.state, notation_);
    if (!group.state_name.empty()) text += fmt::format(" ({})", group.state_name);
    if (group.dpt) text += ", DPT " + to_string(*group.dpt);
    if (text.size() > kMaxLength) return text.substr(0, kMaxLength) + "...";
  }
  return text;
}

model::Join PointTable::join_of(const std::string& device) const {
  const auto& one = devices_.at(device);
  model::Join join;
  const auto& first = points_[one.points.front()].group;
  const bool is_own = to_string(first.address) == device;  // the device is this single group address
  join.name = one.name.empty() && is_own ? first.name : one.name;
  join.model = model_of(one);
  join.area = one.room;
  if (const auto wanted = wanted_ids_.find(device); wanted != wanted_ids_.end()) join.id = wanted->second;
  join.heard = false;
  for (const auto index : one.points) join.capabilities.push_back(capability_of(points_[index], *types_));
  return join;
}

Result<Value> value_of(const BoundPoint& point, wire::PayloadView payload) {
  if (!point.dpt) return Value(base::to_hex(payload.bytes));
  auto value = decode(*point.dpt, payload);
  if (value && point.scenes) return groups::scene_value(point.dpt->id, *point.scenes, payload.bytes[0]);
  return value ? dpt::to_catalogue(*point.dpt, point.id.kind, *value) : value;
}

/// Without a type the value is the payload in hex, in whole bytes: it cannot express the small form.
Result<wire::Payload> payload_of(const BoundPoint& point, const Value& value) {
  if (point.scenes) return groups::scene_payload(point.dpt->id, *point.scenes, value);
  if (point.dpt) {
    auto converted = dpt::from_catalogue(*point.dpt, point.id.kind, value);
    return converted ? encode(*point.dpt, *converted) : Result<wire::Payload>(fail(converted.error()));
  }
  const auto* hex = std::get_if<std::string>(&value);
  auto bytes = hex ? base::from_hex(*hex) : Result<Bytes>(fail(ErrorCode::kInvalid, "expected bytes in hex"));
  if (!bytes) return fail(bytes.error());
  if (bytes->empty() || bytes->size() > wire::kMaxPayload)
    return fail(ErrorCode::kOutOfRange, fmt::format("{} bytes, expected 1 to {}", bytes->size(), wire::kMaxPayload));
  return wire::Payload{std::move(*bytes), false};
}

}  // namespace rubicon::networks::knx
