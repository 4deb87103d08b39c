#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::networks::log {

/// The files that the configured paths name, in playing order. Relative paths start at `directory`. A last part with
/// `*` and `?` is a pattern for file names, sorted in natural order (2 before 10). kNotFound if no file matches it.
Result<std::vector<std::string>> list_files(const std::vector<std::string>& configured, const std::string& directory);

/// Whether a file name matches a pattern with `*` (any number of characters) and `?` (one character).
bool matches_wildcard(std::string_view pattern, std::string_view name);

/// Compares names; numbers in them compare as numbers.
bool natural_less(std::string_view left, std::string_view right);

/// The last number in a file's name, as text without leading zeros; empty if there is none.
std::string number_in_name(std::string_view path);

}  // namespace rubicon::networks::log
