#pragma once

#include <string>

#include "base/config_reader.h"
#include "transport/mqtt_options.h"
#include "tuples/mqtt/mqtt_ecology.h"

namespace rubicon::config {

/// `tuples.mqtt`: the broker at which components of all sites meet (docs/sites.md).
struct MqttSpaceSetup {
  transport::MqttBrokerOptions broker;
  std::string space = "default";
  Duration lease = std::chrono::seconds(20);
  bool trust_broker = false;

  /// With the password, as it is when the program starts; the errors of MqttBrokerOptions::with_password().
  Result<tuples::mqtt::SpaceOptions> options(transport::Transports& transports) const;
  /// `broker.lan:8883, space city`, for texts.
  std::string text() const;
};

/// Reads the map; relative paths start at `directory`. Everything wrong is in the reader's errors.
MqttSpaceSetup read_mqtt_space(ConfigReader& tuples, const std::string& directory);

}  // namespace rubicon::config
