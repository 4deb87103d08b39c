#pragma once

#include <string>
#include <vector>

#include "networks/zigbee/bridge/messages.h"

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

}  // namespace rubicon::networks::zigbee::bridge
