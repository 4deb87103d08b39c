#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_point.h"

namespace rubicon::networks::knx::groups {

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
