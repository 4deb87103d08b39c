#pragma once

#include <mosquitto.h>

#include <memory>

#include "transport/mqtt_exchange.h"

namespace rubicon::transport {

/// What the broker said, without a client id: `properties` of a CONNACK of version 5, else nullptr.
MqttConnack read_connack(const mosquitto_property* properties, bool version_5, Duration our_keep_alive);

/// The most publications of QoS 1 without an answer that the broker takes (Receive Maximum; MQTT 5, section 3.2.2.3.3).
std::size_t read_receive_maximum(const mosquitto_property* properties);

struct FreeProperties {
  void operator()(mosquitto_property* properties) const { ::mosquitto_property_free_all(&properties); }
};
using Properties = std::unique_ptr<mosquitto_property, FreeProperties>;

/// Of a CONNECT of version 5.
Properties connect_properties(const MqttOptions& options);
/// Of a PUBLISH of version 5; nullptr = none.
Properties publish_properties(const MqttPublication& publication);
/// Of a received one; nullptr = none.
std::unique_ptr<MqttAbout> read_about(const mosquitto_property* properties);

}  // namespace rubicon::transport
