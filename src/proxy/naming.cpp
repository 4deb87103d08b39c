#include "proxy/naming.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "base/compare_text.h"
#include "model/type_names.h"
#include "proxy/proxy_config.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

std::string_view to_string(DiscoveryAction action) {
  switch (action) {
    case DiscoveryAction::kAuto: return "auto";
    case DiscoveryAction::kAsk: return "ask";
    case DiscoveryAction::kIgnore: return "ignore";
  }
  return "auto";
}

namespace {

/// `light-1` -> `light-window`; keeps the type.
std::string renamed(const std::map<std::string, std::string>& names, const std::string& id) {
  const auto name = names.find(id);
  if (name == names.end() || name->second.empty()) return id;
  return fmt::format("{}-{}", id.substr(0, id.find('-')), model::to_key_part(name->second, 40));
}

std::string owner_of_property(const DeviceNames& names, const std::string& id) {
  const auto as_sensor = renamed(names.sensors, id);
  return as_sensor != id ? as_sensor : renamed(names.actuators, id);
}

void check_names(const std::string& path, const std::map<std::string, std::string>& names,
                 std::vector<std::string>& out) {
  std::map<std::string, std::string> taken;
  for (const auto& [id, name] : names) {
    const auto [other, fresh] = taken.emplace(renamed(names, id), id);
    if (!fresh) out.push_back(fmt::format("{}: {} and {} both become {}", path, other->second, id, other->first));
  }
}

template <class Map>
void add_lost(const std::string& kind, const std::string& section, const Map& names,
              const std::vector<std::string>& there, std::vector<LostName>& out) {
  constexpr std::size_t kMaxNamed = 20;
  for (const auto& [id, name] : names) {
    if (std::find(there.begin(), there.end(), id) != there.end()) continue;
    const auto near = base::did_you_mean(id, there);
    const std::vector<std::string> some(there.begin(),
                                        there.begin() + static_cast<std::ptrdiff_t>(std::min(there.size(), kMaxNamed)));
    out.push_back({{section, id},
                   fmt::format("the device has no such {}{}{} {}", kind, near.empty() ? ", there are:" : "; ",
                               near.empty() ? "" : near + " There are:",
                               there.empty() ? "none" : fmt::format("{}", fmt::join(some, ", ")))});
  }
}

}  // namespace

std::vector<LostName> lost_names(const DeviceNames& names, const std::vector<std::string>& sensors,
                                 const std::vector<std::string>& actuators) {
  std::vector<LostName> out;
  add_lost("sensor", "sensors", names.sensors, sensors, out);
  add_lost("actuator", "actuators", names.actuators, actuators, out);
  auto both = sensors;
  both.insert(both.end(), actuators.begin(), actuators.end());
  add_lost("sensor or actuator", "valid", names.valid, both, out);
  return out;
}

std::vector<LostName> lost_names(const DeviceNames& names, const Device& device) {
  if (names.sensors.empty() && names.actuators.empty() && names.valid.empty()) return {};
  std::vector<std::string> sensors, actuators;
  for (const auto& point : device.points) {
    if (point.id.kind == Kind::kProperty) continue;
    auto& ids = point.id.kind == Kind::kSensor ? sensors : actuators;
    ids.push_back(point.details->capability->id);
  }
  return lost_names(names, sensors, actuators);
}

const DeviceNames* names_of(const NetworkRules& rules, const std::string& address) {
  const auto names = rules.devices.find(address);
  return names == rules.devices.end() ? nullptr : &names->second;
}

bool adopt_names(NetworkRules& rules, const std::string& address, const std::string& announced) {
  if (!rules.unique_names || announced.empty() || rules.devices.contains(address)) return false;
  auto named = rules.devices.extract(announced);
  if (named.empty()) return false;
  named.key() = address;
  rules.devices.insert(std::move(named));
  return true;
}

std::string device_id(const NetworkRules& rules, const std::string& address, const std::string& wanted) {
  const auto* names = names_of(rules, address);
  if (names && !names->id.empty()) return model::to_key_part(names->id);
  return model::to_key_part(wanted.empty() ? address : wanted);
}

std::string point_id(const DeviceNames* names, const Capability& capability, const Type* type) {
  const auto& instance = capability.point.instance;
  auto id = type ? std::string(type->name) : model::name_in_keys(capability);
  if (capability.point.kind == Kind::kProperty) {
    if (instance.empty()) return id;
    return fmt::format("{}-{}", id, model::to_key_part(names ? owner_of_property(*names, instance) : instance));
  }
  id = fmt::format("{}-{}", id, instance.empty() ? "1" : model::to_key_part(instance, 40));
  if (!names) return id;
  return renamed(capability.point.kind == Kind::kSensor ? names->sensors : names->actuators, id);
}

std::vector<std::string> collisions(const ProxyConfig& config) {
  std::vector<std::string> out;
  std::map<std::string, std::string> networks;
  for (const auto& [network, rules] : config.networks) {
    const auto [twin, fresh] = networks.emplace(model::to_key_part(network), network);
    if (!fresh) out.push_back(fmt::format("networks {} and {} both become {}", twin->second, network, twin->first));
    std::map<std::string, std::string> ids;
    for (const auto& [address, names] : rules.devices) {
      const auto path = fmt::format("networks.{}.devices.{}", network, address);
      const auto [other, alone] = ids.emplace(device_id(rules, address), address);
      if (!alone) {
        out.push_back(fmt::format("networks.{}.devices: {} and {} both become {}", network, other->second, address,
                                  other->first));
      }
      check_names(path + ".sensors", names.sensors, out);
      check_names(path + ".actuators", names.actuators, out);
    }
  }
  return out;
}

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
      const auto* device = network->devices.find(address);
      if (!device || same_keys(names_of(network->rules, address), &names)) continue;
      std::map<std::pair<Kind, std::string>, std::string> taken;
      for (const auto& point : device->points) {
        auto part = point_id(&names, *point.details->capability, point.type);
        const auto [other, free] = taken.emplace(std::pair(point.id.kind, part), point.details->id());
        if (free) continue;
        objections.push_back({id, address,
                              fmt::format("networks.{}.devices.{}: {} and {} would both become {}", id, address,
                                          other->second, point.details->id(), part)});
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
    const auto* device = network->second->devices.find(address);
    if (!device) continue;
    for (const auto& lost : lost_names(names, *device))
      lines.push_back(fmt::format("{}: {}", path_of(*device, lost), lost.text));
  }
  return lines;
}

std::vector<LostName> lost_names_of(const Device& device) {
  const auto* names = names_of(device.network->rules, device.address);
  return names ? lost_names(*names, device) : std::vector<LostName>();
}

}  // namespace rubicon::proxy
