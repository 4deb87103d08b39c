#include "proxy/device.h"

#include <algorithm>

namespace rubicon::proxy {

// A KNX import lists tens of thousands of points: bench/point_bench measures what each costs.
static_assert(sizeof(Point) <= 192);
static_assert(sizeof(Device) <= 464);

std::string_view to_string(DeviceStatus status) {
  switch (status) {
    case DeviceStatus::kUnknown: return "unknown";
    case DeviceStatus::kReachable: return "reachable";
    case DeviceStatus::kUnreachable: return "unreachable";
  }
  return "unknown";
}

bool is_event(const Point& point) {
  return (point.type ? point.type->report : point.details->capability->report) == model::Report::kEvent;
}

bool is_rate(const Point& point) {
  const bool of_device = point.id.kind == Kind::kProperty && point.id.instance.empty();
  return of_device && point.type && point.type->name == "rate" && !model::is_open(point.id.type);
}

std::optional<std::chrono::milliseconds> rate_of(const Value& value) {
  constexpr std::chrono::milliseconds kMaxRate = std::chrono::hours(24);
  const auto* whole = std::get_if<std::int64_t>(&value);
  if (!whole || *whole < 1 || *whole > kMaxRate.count()) return std::nullopt;
  return std::chrono::milliseconds(*whole);
}

Quality shown_quality(const Device& device, const Point& point) {
  if (device.network->down) return Quality::kNetworkDown;
  if (device.status == DeviceStatus::kUnreachable) return Quality::kDeviceOffline;
  return point.quality;
}

model::PointKey point_key(const Device& device, const Point& point) {
  return model::DeviceKey{device.key}.point(point.id.kind, point.details->id);
}

Point* find_point(Device& device, const PointId& id) {
  for (auto& point : device.points) {
    if (point.id.type == id.type && point.id.kind == id.kind && point.id.instance == id.instance) return &point;
  }
  return nullptr;
}

Point* find_point(Device& device, PointNumber number) {
  for (auto& point : device.points) {
    if (point.number == number) return &point;
  }
  return nullptr;
}

}  // namespace rubicon::proxy
