#pragma once

#include <fmt/core.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

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

void append_arguments(std::string& out, fmt::string_view format, fmt::format_args arguments);

/// Appends the formatted text. fmt::format_to would compile fmt's formatting of numbers once more in each block.
template <class... Arguments>
void append(std::string& out, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  append_arguments(out, format, fmt::make_format_args(arguments...));
}

/// Removes the next character of a text in UTF-8 (RFC 3629) and returns it. nullopt, with one byte removed, if the text
/// does not begin with a well-formed one: overlong forms, surrogates and what is above U+10FFFF are not. nullopt for an
/// empty text.
std::optional<char32_t> take_utf8(std::string_view& text);

/// Appends a character in UTF-8; U+FFFD for what is none: surrogates and what is above U+10FFFF. The characters of
/// ISO 8859-1 are U+0000 to U+00FF, so that its bytes can be passed as they are.
void append_utf8(char32_t character, std::string& out);

// Untrusted text (names, values, reasons) for a terminal or a log.

/// Well-formed UTF-8 (RFC 3629): no overlong forms, no surrogates.
bool is_utf8(std::string_view text);
/// Number of bytes at the beginning that are well-formed.
std::size_t utf8_prefix(std::string_view text);
/// Number of UTF-8 characters; each invalid byte counts as one.
std::size_t characters(std::string_view text);
/// The text with `?` for each invalid byte and each character that controls a terminal: controls (U+0000..001F,
/// U+007F..009F), line separators (U+2028, U+2029) and bidirectional marks (U+061C, U+200E, U+200F, U+202A..202E,
/// U+2066..2069; Unicode Standard Annex 9), which show text in another order than it has.
std::string printable(std::string_view text);
/// The same on one line: a control character below U+0020 becomes a blank.
std::string one_line(std::string_view text);
/// printable(), cut to the width in characters, padded with blanks.
std::string fitted(std::string_view text, std::size_t width);
/// The first character, or an invalid byte with its continuation bytes: at least one byte of a text that is not empty.
std::string_view first_character(std::string_view text);

/// Whether brackets outside strings nest in more than `levels` levels. Checked before a text from outside is parsed, it
/// bounds the recursion over the tree. The text need not be valid JSON.
bool is_nested_deeper(std::string_view json, std::size_t levels);

struct HostPort {
  std::string host;        ///< a name or a numeric address, without brackets; may be empty where `text` was `:PORT`
  std::uint16_t port = 0;  ///< 1..65535

  friend bool operator==(const HostPort&, const HostPort&) = default;
};

/// `HOST:PORT`; an IPv6 address stands in brackets (RFC 3986, 3.2.2): `[::1]:9002`. nullopt for everything else, such
/// as a port 0 or an IPv6 address without brackets.
std::optional<HostPort> parse_host_port(std::string_view text);

/// The same, or only `HOST`, which then has the default port.
std::optional<HostPort> parse_host_port(std::string_view text, std::uint16_t default_port);

/// Why a text is not a host to connect to, a name or a numeric address; empty = it may be one. `expected ...` or what
/// it is.
std::string host_fault(std::string_view text);

}  // namespace rubicon::base
