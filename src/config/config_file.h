#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/config_node.h"
#include "rubicon/result.hpp"

namespace rubicon::config {

/// `networks.dummy-1.seed=7` or any other path (a part with dots in double quotes): replaces or creates the value, at
/// the place `--set ...`.
Result<void> apply_override(ConfigNode& root, std::string_view assignment);

/// File -> tree with the overrides applied; kNotFound, kIo or the errors of parse_yaml.
Result<ConfigNode> load_config(const std::string& path, const std::vector<std::string>& overrides);

}  // namespace rubicon::config
