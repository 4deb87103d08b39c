#pragma once

#include <vector>

#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_point.h"

namespace rubicon::networks::knx::groups {

/// Group addresses -> what the network takes, sorted by address. Each address is a sensor or an actuator by its type.
/// With `by_name` the words of its name (words.h) decide first, and a command and a state address become one actuator
/// if they have the same main type, the same main and middle group, and the same name without the words of the table.
/// Every guess by name is a note of the report, counted in `paired` and `kinds_by_name`; so is what could not be
/// decided because several addresses fit.
std::vector<GroupPoint> infer_points(const std::vector<GroupEntry>& entries, bool by_name, Report& report);

}  // namespace rubicon::networks::knx::groups
