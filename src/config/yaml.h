#pragma once

#include <string_view>

#include "base/config_node.h"
#include "rubicon/result.hpp"

namespace rubicon::config {

/// Bounds of a configuration: beyond them it is refused, however it is written.
inline constexpr std::size_t kMaxYamlBytes = 8UL * 1024 * 1024;
inline constexpr std::size_t kMaxYamlNodes = 200'000;

/// One YAML document in UTF-8 whose top is a map -> tree with the place of every node and key. Anchors may stand,
/// aliases are refused (a configuration of a page must not unfold to a million nodes), duplicate keys and tabs as
/// indentation too. Errors read `file:line:column: what`; several lines when several keys are wrong.
Result<ConfigNode> parse_yaml(std::string_view text, std::string_view file_name);

/// A value as it may stand behind `=` on a command line: a scalar, or a list or map in flow style.
Result<ConfigNode> parse_yaml_value(std::string_view text, std::string_view shown_as);

}  // namespace rubicon::config
