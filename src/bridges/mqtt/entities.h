#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bridges/mqtt/house.h"

namespace rubicon::bridges::mqtt {

/// One entity of Home Assistant: `sensor`, `light`, ...
struct Entity {
  std::string platform;
  std::string id;  ///< among those of the device; never changes: `actuator-lamp-1`
  nlohmann::ordered_json body;
};

/// The entities of a device, some of which are made of several points (a lamp with its dimmer). What `takes` refuses is
/// only shown. Sources: documentation and code of Home Assistant's MQTT integration, 2026.1.
std::vector<Entity> entities_of(const DeviceEntry& device, const std::function<bool(const PointEntry&)>& takes);

/// `Colour temperature 1`.
std::string words_of_id(std::string_view id);

}  // namespace rubicon::bridges::mqtt
