#pragma once

#include <vector>

#include "base/config_reader.h"
#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

// Groups that take secured telegrams only (KNX Data Secure), as sorted lists without duplicates.

/// `secured-groups` of a group file or of a network's configuration. What is not an address is reported and left out.
std::vector<wire::GroupAddress> read_secured_groups(ConfigReader& reader);

/// Those of an import.
std::vector<wire::GroupAddress> secured_of(const GroupList& list);

/// Those of a group file after a newer import: an address that the import does not have, or of which it does not know
/// whether it is secured, stays as it is. The report names the differences.
std::vector<wire::GroupAddress> merge_secured(const std::vector<wire::GroupAddress>& known, const GroupList& imported,
                                              Report& report);

/// The addresses of both.
std::vector<wire::GroupAddress> joined(const std::vector<wire::GroupAddress>& one,
                                       const std::vector<wire::GroupAddress>& other);

}  // namespace rubicon::networks::knx::groups
