#pragma once

#include <string>

#include "proxy/device.h"

namespace rubicon::proxy::admission {

/// A device as its network spells it.
struct DeviceName {
  std::string network, address;
  friend auto operator<=>(const DeviceName&, const DeviceName&) = default;
};

/// What a device last announced.
struct Announced {
  model::Join join;
  SteadyTime heard_at{};  ///< meaningless if the join was not heard (Join::heard)
  WallTime joined{};      ///< time of the join, later than those other islands know of (Roaming); zero = not heard
};

/// What a listed device would announce now.
Announced last_announcement(const Device& device);

/// Equal but for the wanted key part and whether it was heard.
bool same_announcement(const model::Join& one, const model::Join& other);

/// The parts of a device's key: `wsn-1.7`.
std::string key_of(const DeviceName& device);

}  // namespace rubicon::proxy::admission
