#pragma once

#include "network/network.h"

namespace rubicon::networks::zigbee {

/// ZigBee devices through Zigbee2MQTT and its MQTT broker: see README.md.
extern const network::NetworkType kType;

}  // namespace rubicon::networks::zigbee
