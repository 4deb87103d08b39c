#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/json_text.h"
#include "rubicon/time.hpp"

// Members of JSON objects that other programs wrote. A member that is missing or of another kind reads as empty, zero
// or false; so does every member of what is not an object. `Tree` is nlohmann::json or ordered_json.
namespace rubicon::model {

/// Seconds since 1970 as a time; zero for what is not between 1970 and the year 5000.
WallTime time_from_seconds(double seconds);
/// The same, the other way round: a whole number where the time has no fraction of a second.
nlohmann::ordered_json seconds_json(WallTime time);
/// Appends microseconds as seconds: `1767225600.25`.
void append_seconds(WallTime time, std::string& out);
/// Appends text as a JSON string; broken UTF-8 is replaced.
void append_json(std::string_view text, std::string& out);

/// The members of the object in the text; none if the text is not an object.
nlohmann::json object_of(std::string_view text);

template <class Tree>
std::string text_of(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_string() ? found->template get<std::string>() : std::string();
}

/// nullopt where there is none: for objects that must have the member.
template <class Tree>
std::optional<std::string> find_text(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  if (found == tree.end() || !found->is_string()) return std::nullopt;
  return found->template get<std::string>();
}

template <class Tree>
double number_of(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_number() ? found->template get<double>() : 0;
}

/// Zero also where a whole number is negative or has more than 64 bits.
template <class Tree>
std::uint64_t count_of(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_number_unsigned() ? found->template get<std::uint64_t>() : 0;
}

template <class Tree>
bool flag_of(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_boolean() && found->template get<bool>();
}

/// A member in seconds since 1970-01-01 UTC.
template <class Tree>
WallTime time_of(const Tree& tree, const char* name) {
  return time_from_seconds(number_of(tree, name));
}

/// The texts of a list; items of another kind are left out.
template <class Tree>
std::vector<std::string> texts_of(const Tree& tree, const char* name) {
  std::vector<std::string> texts;
  const auto found = tree.find(name);
  if (found == tree.end() || !found->is_array()) return texts;
  for (const auto& item : *found) {
    if (item.is_string()) texts.push_back(item.template get<std::string>());
  }
  return texts;
}

}  // namespace rubicon::model
