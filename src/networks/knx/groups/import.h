#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

// Groups that take secured telegrams only (KNX Data Secure), as sorted lists without duplicates.

/// `secured-groups` of a group file or of a network's configuration. What is not an address is reported and left out.
std::vector<wire::GroupAddress> read_secured_groups(ConfigReader& reader);

/// Those of an import.
std::vector<wire::GroupAddress> secured_of(const GroupList& list);

/// Those of a group file after a newer import: an address that the import does not have, or for which it does not know
/// whether it is secured, stays as it is. The report names the differences.
std::vector<wire::GroupAddress> merge_secured(const std::vector<wire::GroupAddress>& known, const GroupList& imported,
                                              Report& report);

/// The addresses of both.
std::vector<wire::GroupAddress> joined(const std::vector<wire::GroupAddress>& one,
                                       const std::vector<wire::GroupAddress>& other);

struct ImportOptions {
  bool guess = true;  ///< false: nothing is inferred from names; what a project states still counts
  std::optional<std::vector<GroupPoint>> known{};   ///< the points of a group file to merge into
  std::vector<wire::GroupAddress> known_secured{};  ///< with `known`: `secured-groups` of that file
};

/// The points of a file, sorted by address, and the report of the import.
struct Import {
  std::vector<GroupPoint> points;
  std::vector<wire::GroupAddress> secured;  ///< these take secured telegrams only; sorted
  Report report;
};

/// `source` is the file's name, for the report. kInvalid with file and line if the file as a whole is refused.
Result<Import> import_text(std::string_view text, const std::string& source, const ImportOptions& options = {});

/// The same for a list that was read already.
Import import_list(GroupList list, const ImportOptions& options = {});

/// Reads a file of at most 64 MiB. Blocks; for start-up and tools. kNotFound, kIo, kOutOfRange, kInvalid.
Result<Import> import_file(const std::string& path, const ImportOptions& options = {});

}  // namespace rubicon::networks::knx::groups
