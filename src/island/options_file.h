#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "island/island_config.h"
#include "transport/transports.h"

namespace rubicon::island {

/// Tells two contents of a file apart, by the option that names the file; 0 = the file cannot be read.
using FileDigests = std::map<std::string, std::size_t>;

/// Of the files that the network's options name (NetworkType::file_options). Options that are not given are left out.
/// Reads at most kLargestOptionsFile bytes of each file, and keeps none of them: some hold passwords.
FileDigests digests_of_options_files(const island::NetworkSetup& setup, const std::string& directory,
                                     transport::Transports& transports);
inline constexpr std::size_t kLargestOptionsFile = 64 << 20;

/// The files that differ, for the user: `keyring file`, `keyring-password-file`.
std::vector<std::string> changed_files(const FileDigests& before, const FileDigests& now);

}  // namespace rubicon::island
