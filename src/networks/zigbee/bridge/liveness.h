#pragma once

#include <optional>

#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/bridge/messages.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::bridge {

/// Longest interval between the reports that the device is configured to send; zero = none is configured. The values 0
/// and 65535 of the maximum interval mean "no periodic reports" (ZigBee Cluster Library, section 2.5.7).
Duration longest_reporting(const DeviceRecord& record);

/// How long a device may be silent where the bridge does not publish its availability: mains powered ones 3 times the
/// longest reporting interval and at least 1 h, others 25 h. nullopt for groups, which have no radio.
std::optional<Duration> silence_limit(const DeviceRecord& record);

/// Who decides whether a device is there: the bridge's availability, if it publishes it, otherwise silence_limit().
bool bridge_decides(const BridgeDescription& info, const DeviceRecord& record);

}  // namespace rubicon::networks::zigbee::bridge
