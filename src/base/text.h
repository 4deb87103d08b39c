#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace rubicon::base {

/// The text without the blanks, tabs, line ends and form feeds at both ends.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n\f";
  const auto first = text.find_first_not_of(kBlanks);
  return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// The number that the whole text spells: no blanks, no `+`, in the range of Number; nullopt otherwise. Real numbers
/// may be `inf` and `nan` (std::from_chars): ask std::isfinite.
template <class Number>
std::optional<Number> parse_number(std::string_view text) {
  Number number{};
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

/// The same in hexadecimal digits, without `0x`.
template <class Number>
requires std::is_integral_v<Number> std::optional<Number> parse_hex_number(std::string_view text) {
  Number number{};
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number, 16);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

/// A path of a configuration: relative ones start at the directory of the file that names them (empty: the working
/// directory). Keeps each `..`, which behind a symbolic link does not lead back.
std::string resolve_path(std::string_view directory, std::string_view path);

}  // namespace rubicon::base
