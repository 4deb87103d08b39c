#pragma once

#include <cstddef>
#include <string>

#include "network/network.h"
#include "transport/mqtt_options.h"

namespace rubicon::networks::zigbee {

/// The options of a network of `type: zigbee`.
struct ZigbeeOptions {
  transport::MqttBrokerOptions broker;
  std::string base = "zigbee2mqtt";   ///< the first part of all topics; may contain slashes
  unsigned polls_per_second = 10;     ///< of the whole network
  std::size_t most_devices = 20'000;  ///< `limits.devices` of the island
};

/// Errors are added to those of the reader.
ZigbeeOptions read_zigbee_options(const network::NetworkConfig& config);

/// Whether both reach the same bridge in the same way.
bool same_line(const ZigbeeOptions& one, const ZigbeeOptions& other);

}  // namespace rubicon::networks::zigbee
