#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "rubicon/key.hpp"

namespace rubicon::bridges {

/// What a bridge shows, and what it lets others do.
struct Scope {
  std::vector<Pattern> patterns;       ///< of values; empty = those of the own island, or of all
  std::vector<std::string> except;     ///< key patterns of values that are left out all the same
  std::vector<std::string> commands;   ///< key patterns of commands that are taken; empty = none
  std::vector<std::string> forbidden;  ///< of those that are not, though `commands` has them
  std::string base = "rubicon";        ///< first levels of topics
  bool friendly = false;               ///< topics have the names of people
  std::string origin{};  ///< property of a network that says where it comes from (House::Callbacks::is_ours)
};

/// `patterns`, `except` and `commands`; reports every error to the reader.
void read_scope(ConfigReader& options, Scope& found);
/// A list of key patterns.
std::vector<std::string> read_keys(ConfigReader& options, const std::string& key);

/// Part by part: `*` in a part stands for any text, the last part `**` for any parts.
bool key_matches(std::string_view pattern, std::string_view key);
bool any_key_matches(const std::vector<std::string>& patterns, std::string_view key);

/// Whether the command with this key is taken.
bool takes_command(const Scope& scope, std::string_view key);

}  // namespace rubicon::bridges
