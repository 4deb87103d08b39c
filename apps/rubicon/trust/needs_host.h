#pragma once

#include <filesystem>
#include <string>

namespace rubicon::cli::trust {

/// Whether the island of a configuration needs no member in this folder: it is without trust or engine dds, or its
/// folder is another one. False also for a configuration that cannot be read.
bool is_of_another_realm(const std::string& configuration, const std::filesystem::path& folder);

}  // namespace rubicon::cli::trust
