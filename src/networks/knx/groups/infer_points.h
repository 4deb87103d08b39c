#pragma once

#include <vector>

#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_point.h"

namespace rubicon::networks::knx::groups {

/// Makes points from group addresses, sorted by address. Where the use of an address is known and one-sided, it decides
/// whether the address is a sensor or an actuator, else its type does. With `by_name`, state addresses that a project
/// names become part of their actuator; then, where the use leaves it open, the words of its name (words.h) decide
/// first, and a command and a state address become one actuator if they have the same main type, the same main and
/// middle group, and the same name without these words. The report gets a note for each inference, counted in `paired`,
/// `kinds_by_name`, `paired_by_project` and `kinds_by_project`, and for each ambiguous pair.
std::vector<GroupPoint> infer_points(const std::vector<GroupEntry>& entries, bool by_name, Report& report);

}  // namespace rubicon::networks::knx::groups
