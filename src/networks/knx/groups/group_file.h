#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_point.h"

namespace rubicon::networks::knx::groups {

/// The record: what a network's configuration says of group addresses, written by `rubicon knx import` or by hand
/// (docs/knx-import.md). Reads `groups` and `group-names` of `reader`, appends to `out` in the order of the file and
/// reports each mistake at its place: bad addresses and types, an address twice, one address as state of two actuators,
/// two points with one key. A point with a mistake is left out.
void read_groups(ConfigReader& reader, std::vector<GroupPoint>& out);

/// What two points claim at once, a line each: one address of two points, one state address of two actuators, one key
/// of two points. For points of several sources together; what one record has twice, read_groups() reports itself.
std::vector<std::string> conflicts(const std::vector<GroupPoint>& points);

/// `demand`, `init`, `never`, `expire 60min`, `every 5min`.
std::optional<ReadRule> parse_read_rule(std::string_view text);
std::string to_string(const ReadRule& rule);

/// The same as YAML: sorted by address, a line a point, equal points give equal text. `source` stands in a comment.
std::string to_yaml(const std::vector<GroupPoint>& points, const std::string& source);

/// Takes a newer import into a record. Frozen by the record: device, instance, kind, type, read rule, pairing. From the
/// import: name, description and groups of what the record knows; addresses it does not know, as new points; a state
/// address for an actuator that has none. What the file no longer has is kept. All but the unchanged is in the report.
/// The result is sorted by address.
std::vector<GroupPoint> merge(std::vector<GroupPoint> known, const std::vector<GroupPoint>& imported, Report& report);

}  // namespace rubicon::networks::knx::groups
