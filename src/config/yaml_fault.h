#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace rubicon::config {

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
