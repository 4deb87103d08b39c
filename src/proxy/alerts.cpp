#include "proxy/alerts.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::proxy {

namespace {

using model::Alert;
using model::AlertList;
using model::Severity;

constexpr TypeId kBatteryLow{0x0215}, kBattery{0x0216}, kBatteryState{0x0266};  // docs/types.md

/// `wsn-1` and `wsn-1.7`: the keys without the prefix of the island.
std::string_view short_key(std::string_view key) {
  return key.substr(key.find('.') + 1);
}

/// `Living room (wsn-1.7)`
std::string titled(const Device& device) {
  const auto key = short_key(device.key);
  return device.name.empty() ? std::string(key) : fmt::format("{} ({})", device.name, key);
}

void add_line(const Network& network, AlertList& list) {
  if (!network.down || network.line == model::LineState::kEnded) return;
  list.add([&] {
    return Alert{
        "line-down",
        network.key,
        Severity::kProblem,
        network.since,
        fmt::format("network {} is {}: {}", network.id, network.line == model::LineState::kRefused ? "refused" : "down",
                    network.reason),
        fmt::format(
            "check cable, power and network of the device that `networks: {}:` names; `rubicon doctor` tests more",
            network.id)};
  });
}

void add_command(const Device& device, const Point& point, WallTime now, AlertList& list) {
  const auto command = model::object_of(point.details->last_command.text());
  const auto since = model::time_of(command, "since");
  if (now - since > kFailureLasts) return;
  list.add([&] {
    return Alert{
        "command-failed",
        point_key(device, point).text,
        Severity::kWarning,
        since,
        fmt::format("{}: {} = '{}' {}: {}", titled(device), point.details->id(), model::text_of(command, "value"),
                    model::text_of(command, "state"), model::text_of(command, "reason")),
        "look at the device, then command it again"};
  });
}

bool is_battery(const Point& point) {
  return point.id.type == kBattery || point.id.type == kBatteryLow || point.id.type == kBatteryState;
}

/// What a low battery says of itself; empty for every other point.
std::string low_battery(const Point& point) {
  const auto& text = point.mirror.text;
  if (point.id.type == kBattery) {
    const auto charge = base::parse_number<double>(text);
    return charge && *charge < kLowBattery ? fmt::format("at {} %", text) : std::string();
  }
  const bool low = (point.id.type == kBatteryLow && text == "on") || (point.id.type == kBatteryState && text == "low");
  return low ? "low" : std::string();
}

void add_battery(const Device& device, const Point& point, AlertList& list) {
  const auto state = low_battery(point);
  if (state.empty()) return;
  list.add([&] {
    return Alert{"battery-low",
                 point_key(device, point).text,
                 Severity::kWarning,
                 point.changed,
                 fmt::format("{}: the battery is {}", titled(device), state),
                 "change or charge the battery"};
  });
}

void add_silent(const Device& device, AlertList& list) {
  list.add([&] {
    return Alert{
        "device-silent",
        device.key,
        Severity::kWarning,
        device.since,
        fmt::format("{} is not reachable: {}", titled(device), device.reason.text()),
        device.unusable ? "change what the reason names" : "check its power or battery, and its way to the network"};
  });
}

template <class Visit>
void each_device(const DeviceDirectory& directory, Visit visit) {
  for (const auto& [id, network] : directory.networks()) {
    if (network->down) continue;
    for (const auto& device : network->devices.all()) visit(*device);
  }
}

}  // namespace

void add_alerts(const DeviceDirectory& directory, WallTime now, AlertList& list) {
  for (const auto& [id, network] : directory.networks()) add_line(*network, list);
  // One walk: with 100,000 devices it is the memory that takes time.
  std::vector<std::pair<const Device*, const Point*>> failed, low;
  std::vector<const Device*> silent;
  each_device(directory, [&](const Device& device) {
    for (const auto& point : device.points) {
      if (point.commands.failed) failed.emplace_back(&device, &point);
      if (is_battery(point)) low.emplace_back(&device, &point);
    }
    if (device.status == DeviceStatus::kUnreachable) silent.push_back(&device);
  });
  for (const auto& [device, point] : failed) add_command(*device, *point, now, list);
  for (const auto& [device, point] : low) add_battery(*device, *point, list);
  for (const auto* device : silent) add_silent(*device, list);
}

}  // namespace rubicon::proxy
