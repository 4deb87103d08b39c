#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace rubicon::bridges::mqtt {

/// What Home Assistant 2026.1 would refuse, drop or warn of in the announcement of a device: keys that it does not
/// know, keys that are missing, classes that do not exist, units that do not fit, ids that are not legal. Empty =
/// nothing. Source: its MQTT integration (schemas, abbreviations) and its classes of sensors.
std::vector<std::string> faults_of(const nlohmann::json& message);

}  // namespace rubicon::bridges::mqtt
