#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "networks/zigbee/bridge/messages.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee {

/// What Zigbee2MQTT can be told to do with a device (`definition.options` in its record, zigbee.md, section 3.1), with
/// the values that its configuration has: {"options":[{"name","value","description","unit","values","minimum",
/// "maximum"}]}. `id`: `0x` and 16 hex digits, or the number of a group; `list` and `info`: the payloads of
/// bridge/devices and bridge/info. kNotFound if the list has no such device, kInvalid if they cannot be read.
Result<nlohmann::json> device_options(std::string_view id, std::string_view list, std::string_view info);

/// For `rubicon zigbee health`: the bridge, and the devices that left or changed their address.
nlohmann::json health_json(const bridge::BridgeHealth& health);

}  // namespace rubicon::networks::zigbee
