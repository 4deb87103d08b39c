#include "proxy/device.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::proxy {

std::string_view to_string(DeviceStatus status) {
  switch (status) {
    case DeviceStatus::kUnknown: return "unknown";
    case DeviceStatus::kReachable: return "reachable";
    case DeviceStatus::kUnreachable: return "unreachable";
  }
  return "unknown";
}

Quality shown_quality(const Device& device, const Point& point) {
  if (device.network->down) return Quality::kNetworkDown;
  if (device.status == DeviceStatus::kUnreachable) return Quality::kDeviceOffline;
  return point.quality;
}

std::string point_key(const Device& device, const Point& point, std::string_view last) {
  return fmt::format("{}.{}.{}.{}", device.key, to_string(point.id.kind), point.details->id, last);
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
