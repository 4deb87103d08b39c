#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_point.h"

namespace rubicon::networks::knx::groups {

/// Reads a group file, the part of a network's configuration that describes group addresses, written by `rubicon knx
/// import` or by hand (docs/knx-import.md): `groups` and `group-names` of `reader`. Appends to `out` in the order of
/// the file. Points with an error (address or type, duplicate address, one state address of two actuators, two points
/// with one key) are reported at their place and left out.
void read_groups(ConfigReader& reader, std::vector<GroupPoint>& out);

/// `notation` of a group file or of a network: how texts for people show group addresses; nullopt if it is absent.
std::optional<wire::Notation> read_notation(ConfigReader& reader);

/// The conflicts between points of several sources, one line each: one address of two points, one state address of two
/// actuators, one key of two points. read_groups() reports those within one file.
std::vector<std::string> conflicts(const std::vector<GroupPoint>& points);

/// `demand`, `init`, `never`, `expire 60min`, `every 5min`.
std::optional<ReadRule> parse_read_rule(std::string_view text);
std::string to_string(const ReadRule& rule);

/// The group file as YAML: sorted by address, one line per point; equal points give equal text. `source` is named in a
/// comment. `secured`: the groups that take secured telegrams only. Addresses are written in `notation`.
std::string to_yaml(const std::vector<GroupPoint>& points, const std::string& source,
                    const std::vector<wire::GroupAddress>& secured = {},
                    wire::Notation notation = wire::Notation::kThreeLevel);

/// Merges a newer import into the points of a group file, sorted by address. Known points keep device, instance, kind,
/// type, read rule and state address; the import sets their name, description and groups. New are addresses that the
/// group file does not have, and state addresses of actuators without one. Addresses that the import does not have are
/// kept. The report lists all differences.
std::vector<GroupPoint> merge(std::vector<GroupPoint> known, const std::vector<GroupPoint>& imported, Report& report);

}  // namespace rubicon::networks::knx::groups
