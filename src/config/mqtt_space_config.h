#pragma once

#include <string>
#include <vector>

#include "base/config_reader.h"
#include "base/host_port.h"
#include "transport/mqtt_options.h"
#include "tuples/mqtt/mqtt_ecology.h"

namespace rubicon::config {

/// `tuples.mqtt`: the broker at which components of all sites meet (docs/sites.md).
struct MqttSpaceSetup {
  transport::MqttBrokerOptions broker;
  std::vector<base::HostPort> spare;  ///< used while those before are away, with the user and TLS of the first
  std::string space = "default";
  Duration lease = std::chrono::seconds(20);
  bool trust_broker = false;
  bool watch_all = false;

  /// With the password, as it is when the program starts; the errors of MqttBrokerOptions::with_password().
  Result<tuples::mqtt::SpaceOptions> options(transport::Transports& transports) const;
  /// The folder of the realm whose authority the broker is checked by (docs/sites.md); empty = it is in none.
  std::string realm_folder() const;
};

/// Reads the map; relative paths start at `directory`. Everything wrong is in the reader's errors.
MqttSpaceSetup read_mqtt_space(ConfigReader& tuples, const std::string& directory);

}  // namespace rubicon::config
