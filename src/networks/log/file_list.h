#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::networks::log {

/// Paths as configured -> paths of files, in playing order. Relative ones start at `directory`; `*` and `?` in the last
/// part stand for what is there, in natural order (2 before 10). kNotFound if a pattern fits nothing.
Result<std::vector<std::string>> list_files(const std::vector<std::string>& configured, const std::string& directory);

/// A configured path as seen from here; relative ones start at `directory`.
std::string resolved(const std::string& path, const std::string& directory);

/// Whether a file name fits a pattern with `*` (any run) and `?` (one character).
bool fits_wildcard(std::string_view pattern, std::string_view name);

/// Numbers inside names count as numbers.
bool natural_less(std::string_view left, std::string_view right);

/// The last number in a file's name, as text without leading zeros; empty if there is none.
std::string number_in_name(std::string_view path);

}  // namespace rubicon::networks::log
