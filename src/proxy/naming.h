#pragma once

#include <string>
#include <vector>

#include "model/point.h"
#include "proxy/device.h"
#include "proxy/device_directory.h"
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

// Problems that new rules would cause for the devices listed now, one line each. Printed by a reload.

/// Why the names of a device cannot be applied.
struct Objection {
  std::string network, address;
  std::string text;
};

/// Names by which two points of one device would claim one key: the rules cannot be applied.
std::vector<Objection> key_conflicts(const DeviceDirectory& directory, const ProxyConfig& next);

/// Names for points that the devices of the network do not have.
std::vector<std::string> lost_names_in(const DeviceDirectory& directory, const std::string& network,
                                       const NetworkRules& next);
/// Those of one device, in the present rules: path in the configuration and text.
std::vector<LostName> lost_names_of(const Device& device);
/// `networks.wsn-1.devices.7.sensors.lihgt-1`
std::string path_of(const Device& device, const LostName& lost);

/// True if both give the device and its points the same keys; nullptr = no names.
bool same_keys(const DeviceNames* one, const DeviceNames* other);

}  // namespace rubicon::proxy
