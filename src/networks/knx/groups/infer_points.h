#pragma once

#include <optional>
#include <vector>

#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

/// The most likely kind of a group address of this type. Switches, dimming, blinds, scenes, setpoints,
/// modes and colours are commanded; measured values, counters, texts, dates and sets of status bits are read. Without
/// a type: a sensor, which cannot be commanded by mistake. docs/knx-import.md has the table.
Kind kind_of_type(std::optional<dpt::DptId> type);

/// Makes points from group addresses, sorted by address. Where the use of an address is known and one-sided, it decides
/// whether the address is a sensor or an actuator, else its type does. With `by_name`, state addresses that a project
/// names become part of their actuator; then, where the use leaves it open, the words of its name (words.h) decide
/// first, and a command and a state address become one actuator if they have the same main type, the same main and
/// middle group, and the same name without these words. The report gets a note for each inference, counted in `paired`,
/// `kinds_by_name`, `paired_by_project` and `kinds_by_project`, and for each ambiguous pair.
std::vector<GroupPoint> infer_points(const std::vector<GroupEntry>& entries, bool by_name, Report& report);

}  // namespace rubicon::networks::knx::groups
