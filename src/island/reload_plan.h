#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "island/island_config.h"
#include "transport/transports.h"

namespace rubicon::island {

/// What taking another configuration would do to a running island.
struct ReloadPlan {
  std::vector<std::string> refusals;                 ///< what needs a restart; anything here = nothing is done
  std::vector<std::string> removed, added, changed;  ///< network ids; changed = their plug-ins get new options
  std::vector<std::string> retyped;                  ///< networks whose type changed: removed and added
  std::vector<std::string> lines;                    ///< everything, for people; empty = nothing changes
  std::vector<std::string> warnings;                 ///< names in `devices:` that fit nothing
};

ReloadPlan plan_reload(const IslandConfig& now, const IslandConfig& next);

/// Tells two contents of a file apart, by the option that names the file; 0 = the file cannot be read.
using FileDigests = std::map<std::string, std::size_t>;

/// Of the files that the network's options name (NetworkType::file_options). Options that are not given are left out.
/// Reads at most kMaxOptionsFile bytes of each file, and keeps none of them: some hold passwords.
FileDigests digests_of_options_files(const island::NetworkSetup& setup, const std::string& directory,
                                     transport::Transports& transports);
inline constexpr std::size_t kMaxOptionsFile = 64 << 20;

/// The files that differ, for the user: `keyring file`, `keyring-password-file`.
std::vector<std::string> changed_files(const FileDigests& before, const FileDigests& now);

}  // namespace rubicon::island
