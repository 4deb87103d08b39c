#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/config_reader.h"
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

/// The tree as YAML for people and programs that read it over the tuple space: secrets are `****` (base/log.h),
/// comments and anchors are gone. Short maps and lists stand on one line. Beyond `most` bytes it ends with a comment
/// that says so, after a whole line.
std::string yaml_text(const ConfigNode& root, std::size_t most);

/// A place in a YAML text, line and column (bytes) from 1, and what is wrong there in words for its author.
struct YamlFault {
  int line = 1;
  int column = 1;
  std::string text;
};

/// A quote that opens and never closes, in a text that the parser took, as it takes such ones. `last_line` is the line
/// in which the last value begins that it saw: only that one can be open. Cost: one pass.
std::optional<YamlFault> unclosed_quote(std::string_view text, int last_line);

/// What made the parser refuse a text: brackets and quotes where they open, other faults where the parser stopped or in
/// the line before it, in words of ours. `parsers` is what the parser said.
YamlFault explain_yaml_fault(std::string_view text, const YamlFault& parsers);

}  // namespace rubicon::config
