#include "networks/log/last_readings.h"

namespace rubicon::networks::log {

void LastReadings::joined(const std::string& device, const model::Join& join) {
  auto& known = devices_[device];
  for (const auto& capability : join.capabilities) {
    if (capability.report == model::Report::kEvent) known.events.insert(capability.point);
  }
}

bool LastReadings::is_event(const Device& device, const model::PointId& point) const {
  const auto* type = types_.find(point.type);
  return type ? type->report == model::Report::kEvent : device.events.contains(point);
}

void LastReadings::keep(const std::string& device, const model::Updates& updates, WallTime when) {
  auto& known = devices_[device];
  for (const auto& reading : updates.readings) {
    if (is_event(known, reading.point)) continue;
    auto& last = known.last[reading.point] = reading;
    if (last.user_time == WallTime{}) last.user_time = when;
  }
}

void LastReadings::clear() {
  for (auto& [device, known] : devices_) known.last.clear();
}

std::vector<std::pair<std::string, model::Body>> LastReadings::take() {
  std::vector<std::pair<std::string, model::Body>> messages;
  for (auto& [device, known] : devices_) {
    if (known.last.empty()) continue;
    model::Updates updates;
    for (auto& [point, reading] : known.last) updates.readings.push_back(std::move(reading));
    messages.emplace_back(device, std::move(updates));
  }
  clear();
  return messages;
}

}  // namespace rubicon::networks::log
