#include "proxy/reload_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <utility>

namespace rubicon::proxy {

bool same_keys(const DeviceNames* one, const DeviceNames* other) {
  static const DeviceNames kNone;
  const auto& a = one ? *one : kNone;
  const auto& b = other ? *other : kNone;
  return a.id == b.id && a.sensors == b.sensors && a.actuators == b.actuators;
}

std::vector<Objection> key_conflicts(const DeviceDirectory& directory, const ProxyConfig& next) {
  std::vector<Objection> objections;
  for (const auto& [id, network] : directory.networks()) {
    const auto rules = next.networks.find(id);
    if (rules == next.networks.end()) continue;
    for (const auto& [address, names] : rules->second.devices) {
      const auto device = network->devices.find(address);
      if (device == network->devices.end() || same_keys(names_of(network->rules, address), &names)) continue;
      std::map<std::pair<Kind, std::string>, std::string> taken;
      for (const auto& point : device->second.points) {
        auto part = point_id(&names, *point.details->capability, point.type);
        const auto [other, free] = taken.emplace(std::pair(point.id.kind, part), point.details->id);
        if (free) continue;
        objections.push_back({id, address,
                              fmt::format("networks.{}.devices.{}: {} and {} would both become {}", id, address,
                                          other->second, point.details->id, part)});
      }
    }
  }
  return objections;
}

std::string path_of(const Device& device, const LostName& lost) {
  return fmt::format("networks.{}.devices.{}.{}", device.network->id, device.address, fmt::join(lost.path, "."));
}

std::vector<std::string> lost_names_in(const DeviceDirectory& directory, const std::string& id,
                                       const NetworkRules& next) {
  std::vector<std::string> lines;
  const auto network = directory.networks().find(id);
  if (network == directory.networks().end()) return lines;
  for (const auto& [address, names] : next.devices) {
    const auto device = network->second->devices.find(address);
    if (device == network->second->devices.end()) continue;
    for (const auto& lost : lost_names(names, device->second))
      lines.push_back(fmt::format("{}: {}", path_of(device->second, lost), lost.text));
  }
  return lines;
}

std::vector<LostName> lost_names_of(const Device& device) {
  const auto* names = names_of(device.network->rules, device.address);
  return names ? lost_names(*names, device) : std::vector<LostName>();
}

}  // namespace rubicon::proxy
