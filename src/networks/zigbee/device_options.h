#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "networks/zigbee/bridge/messages.h"

namespace rubicon::networks::zigbee {

/// What Zigbee2MQTT can be told to do with a device, with the values that its configuration has:
/// {"options":[{"name","value","description","unit","values","minimum","maximum"}]}. `id`: `0x` and 16 hex digits, or
/// the number of a group; `definition`: DeviceRecord::options; `info`: the payload of bridge/info.
nlohmann::json device_options(std::string_view id, const std::vector<std::string>& definition, std::string_view info);

/// For `rubicon zigbee health`: the bridge, and the devices that left or changed their address.
nlohmann::json health_json(const bridge::BridgeHealth& health);

}  // namespace rubicon::networks::zigbee
