#pragma once

#include <optional>
#include <string>
#include <vector>

#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/bridge/messages.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::bridge {

/// A setting of the bridge that should be another one.
struct Recommendation {
  std::string setting;  ///< path in the bridge's configuration.yaml: `advanced.last_seen`
  std::string is, should;
  std::string why;  ///< a sentence for people
  friend bool operator==(const Recommendation&, const Recommendation&) = default;
};

/// The settings that differ from those that we recommend (zigbee.md, section 1), the most important first.
std::vector<Recommendation> recommendations(const BridgeDescription& info);

/// Longest interval between the reports that the device is configured to send; zero = none is configured. The values 0
/// and 65535 of the maximum interval mean "no periodic reports" (ZigBee Cluster Library, section 2.5.7).
Duration longest_reporting(const DeviceRecord& record);

/// How long a device may be silent where the bridge does not publish its availability: mains powered ones 3 times the
/// longest reporting interval and at least 1 h, others 25 h. nullopt for groups, which have no radio.
std::optional<Duration> silence_limit(const DeviceRecord& record);

/// What decides whether a device is there: the bridge's availability, if it publishes it, otherwise silence_limit().
bool bridge_decides(const BridgeDescription& info, const DeviceRecord& record);

}  // namespace rubicon::networks::zigbee::bridge
