#pragma once

#include <string>
#include <vector>

#include "proxy/device_directory.h"
#include "proxy/naming.h"

namespace rubicon::proxy {

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
