#pragma once

#include <string>
#include <vector>

#include "model/point.h"
#include "proxy/device.h"
#include "proxy/proxy_config.h"

namespace rubicon::proxy {

/// Every pair of names in a configuration that would claim one key, one line each; empty = none.
std::vector<std::string> collisions(const ProxyConfig& config);

/// Key part of a device: the configured id, else the one its network proposes, else its address (`1.4.6` -> `1_4_6`).
std::string device_id(const NetworkRules& rules, const std::string& address, const std::string& wanted = {});

/// Key part of a sensor or actuator: type and instance, always both, the instance as named at installation time
/// (`light-window`). A property: its type, and what it belongs to (`rate`, `threshold-light-window`).
std::string point_id(const DeviceNames* names, const Capability& capability, const Type* type);

/// A name in the configuration for a point that the device does not have.
struct LostName {
  std::vector<std::string> path;  ///< below the device: `sensors`, `lihgt-1`
  std::string text;               ///< which points there are
};
/// The names given to points that a device with these sensors and actuators (default ids, `light-1`) does not have.
std::vector<LostName> lost_names(const DeviceNames& names, const std::vector<std::string>& sensors,
                                 const std::vector<std::string>& actuators);
/// The same for a listed device.
std::vector<LostName> lost_names(const DeviceNames& names, const Device& device);

/// The names given to a device at installation time, or nullptr.
const DeviceNames* names_of(const NetworkRules& rules, const std::string& address);
/// Where names are unique: what the configuration gives to the announced name belongs to this address from now on, so
/// that a rename does not move it. True if there was such an entry, and none for the address itself.
bool adopt_names(NetworkRules& rules, const std::string& address, const std::string& announced);

}  // namespace rubicon::proxy
