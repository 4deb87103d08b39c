#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "bridges/bridge.h"
#include "bridges/scope.h"
#include "transport/mqtt_options.h"

namespace rubicon::bridges::mqtt {

/// Shows devices and values on an MQTT broker, to Home Assistant as devices with entities, and takes commands from
/// there (docs/mqtt.md). As BridgeType::make.
std::unique_ptr<Bridge> make(ConfigReader& options, const std::string& directory, const BridgeHost* host);

/// How Home Assistant learns what there is.
enum class Discovery : std::uint8_t {
  kNone,
  kDevices,   ///< one message a device: Home Assistant from 2026.1, openHAB from 5.2
  kEntities,  ///< one message an entity: older ones, and others
};

/// `bridges.<name>` of type mqtt (docs/mqtt.md).
struct Options : Scope {
  transport::MqttBrokerOptions broker;
  std::string discovery_base = "homeassistant";
  Discovery discovery = Discovery::kNone;
  std::string page;                 ///< address of a page of the island, for links to devices; empty = none
  std::vector<std::string> active;  ///< key patterns of values for which sensors are sampled
  bool on_request = false;          ///< a message to `.../sample` has a sensor sampled
  bool json = false;                ///< payloads are objects with value, unit, quality, time
  bool attributes = false;          ///< quality, times and the last command of each point on a topic of their own
  bool keep = false;                ///< values that are not good any longer stay retained
};

/// Reports every error to the reader.
Options read_options(ConfigReader& options, const std::string& directory);

}  // namespace rubicon::bridges::mqtt
