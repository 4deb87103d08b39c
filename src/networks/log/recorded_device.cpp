#include "networks/log/recorded_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/text.h"
#include "model/point.h"
#include "model/point_tuples.h"
#include "model/type_names.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::log {

namespace {

/// As many points as a proxy accepts for a device. Limits the memory that a hostile recording takes.
constexpr std::size_t kMaxListed = 1024;

std::vector<std::string> limited(std::vector<std::string> texts) {
  std::erase(texts, std::string());
  if (texts.size() > kMaxListed) texts.resize(kMaxListed);
  return texts;
}

std::string instance_part(std::string_view id) {
  const auto dash = id.find('-');
  return dash == id.npos ? std::string() : std::string(id.substr(dash + 1));
}

Access access_of(std::string_view word, Kind kind) {
  for (const auto access : {Access::kRead, Access::kWrite, Access::kReadWrite}) {
    if (word == to_string(access)) return access;
  }
  return kind == Kind::kActuator ? Access::kReadWrite : Access::kRead;
}

bool has_unit(const Type* type) {
  const bool is_number =
      type != nullptr && (type->data == model::DataType::kReal || type->data == model::DataType::kInteger);
  return is_number && type->unit != "1";
}

/// nullptr: there is none.
std::unique_ptr<const model::UnitConversion> conversion_of(std::string_view unit, const Type& type) {
  const auto found = model::conversion(unit, type.unit);
  return found ? std::make_unique<const model::UnitConversion>(*found) : nullptr;
}

/// A point of an open type describes how its values are read.
void set_open_type(RecordedPoint& point, const model::PointDescription& described) {
  auto& capability = point.capability;
  capability.data = model::parse_data_type(described.data_type);
  if (!capability.data) return;
  point.own_type = std::make_shared<const model::OpenType>(capability);
  point.type = &point.own_type->type();
}

/// Rule 4 of the deadlines (docs/tuple-keys.md); the network's option sets the others.
void set_deadline(RecordedPoint& point) {
  const bool event = point.type != nullptr && point.type->report == model::Report::kEvent;
  if (point.kind != Kind::kSensor || event) point.capability.deadline = Duration::zero();
}

}  // namespace

std::string_view type_part(std::string_view id) {
  return id.substr(0, id.find('-'));
}

bool ForeignTypes::is_free(TypeId id) const {
  if (id == TypeId{} || types_.find(id) != nullptr) return false;
  return std::none_of(given_.begin(), given_.end(), [id](const auto& one) { return one.second == id; });
}

const Type* ForeignTypes::find(const std::string& name, TypeId& id) {
  if (const auto* known = types_.find(name)) {
    id = known->id;
    return known;
  }
  if (const auto given = given_.find(name); given != given_.end()) {
    id = given->second;
    return nullptr;
  }
  while (!is_free(id) && next_ > 0) id = TypeId(next_--);
  given_.emplace(name, id);
  return nullptr;
}

bool ForeignTypes::has_room(const std::string& name) const {
  return name.size() <= kMaxName && (known(name) != nullptr || given_.contains(name) || given_.size() < kMaxForeign);
}

bool ForeignTypes::take_key_type(std::string_view name) {
  if (known(name) != nullptr || in_keys_.contains(name)) return true;
  if (in_keys_.size() >= kMaxInKeys) return false;
  in_keys_.emplace(name);
  return true;
}

std::size_t RecordedDevice::text_cost() const {
  std::size_t texts = capabilities.size();
  for (const auto& ids : listed) texts += ids.size();
  return text.empty() ? 0 : text.size() + texts * sizeof(std::string);
}

bool RecordedDevice::complete() const {
  if (text.empty()) return false;
  for (std::size_t kind = 0; kind < listed.size(); ++kind) {
    for (const auto& one : listed[kind]) {
      const auto point = points.find({static_cast<Kind>(kind), one});
      if (point == points.end() || point->second.text.empty()) return false;
    }
  }
  return true;
}

namespace {

std::array<std::set<std::string_view>, 3> listed_in(const RecordedDevice& device) {
  std::array<std::set<std::string_view>, 3> sets;
  for (std::size_t kind = 0; kind < sets.size(); ++kind)
    sets[kind] = {device.listed[kind].begin(), device.listed[kind].end()};
  return sets;
}

}  // namespace

bool describe(RecordedDevice& device, std::string_view text) {
  auto described = model::device_description_from_json(text);
  if (!described) return false;
  device.text = text;
  device.address = std::move(described->address);
  device.name = std::move(described->name);
  device.model = std::move(described->model);
  device.type = std::move(described->type);
  device.listed = {limited(std::move(described->sensors)), limited(std::move(described->actuators)),
                   limited(std::move(described->properties))};
  device.capabilities = limited(std::move(described->capabilities));
  const auto listed = listed_in(device);
  for (auto& [key, point] : device.points) {
    if (listed[static_cast<std::size_t>(key.first)].contains(key.second)) continue;
    point.alive = point.joined = false;
    point.waiting.reset();
  }
  return true;
}

const model::PointDescription* PointDescriptions::read(std::string_view text) {
  if (const auto known = kept_.find(text); known != kept_.end()) return &known->second;
  auto described = model::point_description_from_json(text);
  if (!described) return nullptr;
  if (text.size() > kMaxText) return &last_.emplace(std::move(*described));
  if (kept_.size() >= kMaxKept) kept_.clear();
  return &kept_.emplace(text, std::move(*described)).first->second;
}

bool describe(RecordedPoint& point, std::string_view text, ForeignTypes& types, PointDescriptions& descriptions) {
  const auto* described = descriptions.read(text);
  if (!described) return false;
  const auto& type_name = described->type;
  // In keys a type without a name is called by its number.
  const auto name = type_name.empty() ? std::string(type_part(point.id)) : type_name;
  if (!types.has_room(name)) return false;
  point.text = text;
  auto& capability = point.capability;
  capability = {};
  capability.type_name = model::current_type(type_name);
  const auto id = static_cast<std::uint16_t>(std::min<std::uint64_t>(described->type_id, UINT16_MAX));
  capability.point = {point.kind, TypeId(id), instance_part(point.id)};
  point.type = types.find(name, capability.point.type);
  capability.access = access_of(described->access, point.kind);
  if (point.type == nullptr && described->report == "event") capability.report = model::Report::kEvent;
  const auto& unit = described->unit;
  point.unit = has_unit(point.type) && unit != point.type->unit ? conversion_of(unit, *point.type) : nullptr;
  if (point.type == nullptr || (unit != point.type->unit && !point.unit)) capability.unit = unit;
  const auto own_bound = [&](std::optional<double> bound, double of_type) {
    if (bound && point.type && *bound == of_type) bound.reset();
    if (bound && point.unit) bound = (*point.unit)(*bound);
    return bound;
  };
  capability.minimum = own_bound(described->minimum, point.type ? point.type->minimum : 0);
  capability.maximum = own_bound(described->maximum, point.type ? point.type->maximum : 0);
  const bool enumeration = point.type != nullptr && point.type->data == model::DataType::kEnumeration;
  if (point.type == nullptr || point.type->words.empty() ||
      (enumeration && described->words != model::words_in(point.type->words))) {
    capability.words = described->words;
    if (capability.words.size() > kMaxListed) capability.words.resize(kMaxListed);
  }
  if (point.type == nullptr && model::is_open(TypeId(id))) set_open_type(point, *described);
  set_deadline(point);
  return true;
}

namespace {

/// For points without a recorded description.
void describe_by_id(RecordedPoint& point, ForeignTypes& types) {
  auto& capability = point.capability;
  capability = {};
  capability.type_name = type_part(point.id);
  capability.point = {point.kind, TypeId{}, instance_part(point.id)};
  point.type = types.find(capability.type_name, capability.point.type);
  capability.access = point.kind == Kind::kActuator ? Access::kReadWrite : Access::kRead;
  set_deadline(point);
}

/// The points in the order of the original join, as far as it can be known: recorded lists are by kind, the list of
/// capabilities shows the order of their types.
std::vector<RecordedDevice::PointKey> in_order(const RecordedDevice& device) {
  std::vector<RecordedDevice::PointKey> order;
  std::array<std::size_t, 3> next{};
  std::size_t named = 0;
  std::set<std::string_view> types;
  const auto take = [&](const auto& fits) {
    for (std::size_t kind = 0; kind < next.size(); ++kind) {
      const auto& ids = device.listed[kind];
      if (next[kind] == ids.size() || !fits(type_part(ids[next[kind]]))) continue;
      order.emplace_back(static_cast<Kind>(kind), ids[next[kind]++]);
      return true;
    }
    return false;
  };
  const auto seen = [&types](std::string_view type) { return types.contains(type); };
  for (;;) {
    if (take(seen)) continue;
    if (named < device.capabilities.size()) {
      types.insert(device.capabilities[named++]);
      continue;
    }
    if (!take([](std::string_view) { return true; })) return order;
  }
}

}  // namespace

model::Join join_of(RecordedDevice& device, ForeignTypes& types) {
  model::Join join;
  join.device_type = device.type;
  join.name = device.name;
  join.model = device.model;
  join.id = device.id;
  auto order = in_order(device);
  const auto listed = listed_in(device);
  for (auto& [key, point] : device.points) {
    point.joined = false;
    if (point.alive && !listed[static_cast<std::size_t>(key.first)].contains(key.second)) order.push_back(key);
  }
  for (const auto& key : order) {
    const auto found = device.points.find(key);
    if (found == device.points.end() || std::exchange(found->second.joined, true)) continue;
    auto& point = found->second;
    if (point.text.empty()) describe_by_id(point, types);
    if (point.waiting && point.waiting->user_time == WallTime{} && !device.joined()) {
      point.capability.initial = in_unit_of_type(point, std::move(point.waiting->value));
      point.waiting.reset();
    }
    join.capabilities.push_back(point.capability);
    point.capability.initial = {};
  }
  return join;
}

Value in_unit_of_type(const RecordedPoint& point, Value value) {
  if (!point.unit) return value;
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return (*point.unit)(static_cast<double>(*whole));
  if (const auto* real = std::get_if<double>(&value)) return (*point.unit)(*real);
  return value;
}

bool RecordedStatus::is_heard(WallTime written) const {
  constexpr std::chrono::milliseconds kOneTurn(100);
  if (is_live()) return true;
  return quality != Quality::kStored && heard != WallTime{} && written - heard <= kOneTurn;
}

std::optional<RecordedStatus> recorded_status(std::string_view text) {
  const auto status = model::heard_quality_from_json(text);
  if (!status) return std::nullopt;
  return RecordedStatus{status->quality, status->heard};
}

namespace {

/// Whole numbers stay whole: as a real number 100000 would be shown as 1e+05.
Result<Value> real_value(const Type& type, std::string_view text) {
  const bool has_point = text.find('.') != text.npos;  // most do
  if (const auto whole = has_point ? std::nullopt : base::parse_number<std::int64_t>(text)) return Value(*whole);
  const auto real = base::parse_number<double>(text);
  if (real && std::isfinite(*real)) return Value(*real);
  return fail(ErrorCode::kInvalid, fmt::format("{}: {} is not a number", type.name, model::quoted(text)));
}

}  // namespace

Result<Value> recorded_value(const Type* type, std::string_view text, std::string_view media_type) {
  const bool json = type != nullptr ? type->data == model::DataType::kJson : media_type == "application/json";
  if (json) return Value(Json{std::string(text)});
  if (type == nullptr) return Value(std::string(text));
  switch (type->data) {
    case model::DataType::kReal: return real_value(*type, text);
    case model::DataType::kText:
    case model::DataType::kBytes: return Value(std::string(text));
    default: return TypeCatalogue::parse_reading(*type, text);
  }
}

}  // namespace rubicon::networks::log
