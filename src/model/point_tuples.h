#pragma once

#include <string>
#include <string_view>

#include "rubicon/point.hpp"

namespace rubicon::model {

// The JSON of the `.status` tuples (docs/tuple-keys.md). Times are seconds since 1970 UTC. What is missing or of
// another kind reads as empty or zero.

PointStatus point_status_from_json(std::string_view text);
DeviceCondition device_condition_from_json(std::string_view text);
std::string device_condition_to_json(const DeviceCondition& condition);
LineStatus line_status_from_json(std::string_view text);
std::string line_status_to_json(const LineStatus& status);

}  // namespace rubicon::model
