#include "networks/salad/salad_points.h"

#include <fmt/format.h>

#include <cmath>

#include "base/text.h"

namespace rubicon::networks::salad {

namespace {

using model::PointId;

/// The symbolic name in lower case: `fridge` (salad.md, section 7).
std::string instance_of(const SaladDevice& device) {
  std::string instance = device.name;
  for (char& c : instance) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return instance;
}

PointId point_of(const SaladDevice& device, Kind kind) {
  return {kind, device.type_id, instance_of(device)};
}

bool is_actuator(const SaladDevice& device) {
  return !device.sensor || !device.actuator.empty();
}

Value typed(const Type& type, const Value& value) {
  const auto* whole = std::get_if<std::int64_t>(&value);
  if (type.data == model::DataType::kBoolean && whole && (*whole == 0 || *whole == 1)) return Value(*whole == 1);
  const auto* digits = std::get_if<std::string>(&value);
  if (type.data != model::DataType::kReal || !digits) return value;
  return Value(base::parse_number<double>(*digits).value_or(0));
}

}  // namespace

model::Join join_of(const SaladDevice& device) {
  model::Join join;
  join.name = device.name;
  join.model = "SALAD " + device.type;
  join.heard = false;
  if (device.sensor) join.capabilities.emplace_back().point = point_of(device, Kind::kSensor);
  if (!is_actuator(device)) return join;
  auto& actuator = join.capabilities.emplace_back();
  actuator.point = point_of(device, Kind::kActuator);
  actuator.access = device.actuator.empty() ? model::Access::kRead : model::Access::kReadWrite;
  return join;
}

model::Updates updates_of(const SaladDevice& device, const Type& type, const Value& value) {
  model::Updates updates;
  if (device.sensor) updates.readings.push_back({point_of(device, Kind::kSensor), typed(type, value), {}});
  if (is_actuator(device)) updates.readings.push_back({point_of(device, Kind::kActuator), typed(type, value), {}});
  return updates;
}

Result<std::int64_t> command_of(const SaladDevice& device, const Type& type, const model::Actuate& command) {
  if (command.point != point_of(device, Kind::kActuator) || !is_actuator(device))
    return fail(ErrorCode::kNotFound, fmt::format("{} has no such actuator", device.name));
  if (device.actuator.empty())
    return fail(ErrorCode::kRefused,
                fmt::format("{} has no actuator id, so SALAD takes no commands for it", device.name));
  if (auto fits = TypeCatalogue::check(type, command.value); !fits) return fail(fits.error());
  if (const auto* on = std::get_if<bool>(&command.value)) return *on ? 1 : 0;
  if (const auto* whole = std::get_if<std::int64_t>(&command.value)) return *whole;
  const auto* real = std::get_if<double>(&command.value);
  if (real && std::floor(*real) == *real && std::abs(*real) < 1e15) return static_cast<std::int64_t>(*real);
  return fail(ErrorCode::kOutOfRange, fmt::format("{}: SALAD takes whole numbers only", device.name));
}

}  // namespace rubicon::networks::salad
