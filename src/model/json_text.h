#pragma once

#include <concepts>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

// The one place where JSON is parsed and written: the parser and the serializer of nlohmann-json take the compiler a
// second in each block that calls them.
namespace rubicon::model {

/// The tree of a text; discarded (is_discarded()) where the text is no JSON. Its recursion is as deep as the text
/// nests: for texts from outside, base::is_nested_deeper() first.
nlohmann::json parse_json(std::string_view text);
/// The same; keeps the order of members, and searches all members for each that it adds.
nlohmann::ordered_json parse_ordered_json(std::string_view text);

bool is_json(std::string_view text);

/// On one line; broken UTF-8 is replaced.
std::string dump(const nlohmann::ordered_json& tree);
std::string dump_sorted(const nlohmann::json& tree);
template <std::same_as<nlohmann::json> Tree>
std::string dump(const Tree& tree) {
  return dump_sorted(tree);
}
/// The same with escapes (`\u00e9`) for all that is not ASCII.
std::string dump_ascii(const nlohmann::json& tree);

}  // namespace rubicon::model
