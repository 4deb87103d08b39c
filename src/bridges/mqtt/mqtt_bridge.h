#pragma once

#include "bridges/bridge.h"

namespace rubicon::bridges::mqtt {

/// Shows devices and values on an MQTT broker, to Home Assistant as devices with entities, and takes commands from
/// there (docs/mqtt.md). As BridgeType::make.
std::unique_ptr<Bridge> make(ConfigReader& options, const std::string& directory, const BridgeHost* host);

}  // namespace rubicon::bridges::mqtt
