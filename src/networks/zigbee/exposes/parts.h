#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "networks/zigbee/exposes/leaf.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::exposes {

// The value of a composite or list in a set message, before it is sent: Zigbee2MQTT does not answer one that it
// rejects. `where` names the value in errors: `warning.mode`. Parts that are null are left to Zigbee2MQTT.

/// Checks the members of an object against the features of a composite, and respells words as the definition has them.
/// kInvalid for a member that no feature has and for a word that the feature has not, kOutOfRange for a number beyond
/// its bounds. A composite without features takes everything.
Result<void> check_members(const std::vector<Leaf>& features, const std::string& where, nlohmann::json& object);
/// The same for the items of a list; `item` has one leaf, or none for a list of anything.
Result<void> check_items(const std::vector<Leaf>& item, const std::string& where, nlohmann::json& list);

}  // namespace rubicon::networks::zigbee::exposes
