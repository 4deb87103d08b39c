#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace rubicon::base {

// Text of outsiders (names, values, reasons) for a screen or a log.

/// Well-formed UTF-8 (RFC 3629): no overlong forms, no surrogates.
bool is_utf8(std::string_view text);
/// How many bytes at the front are that.
std::size_t utf8_prefix(std::string_view text);
/// UTF-8 characters (broken bytes count as one each).
std::size_t characters(std::string_view text);
/// The text with `?` for each broken byte and each character that steers a terminal: controls (U+0000..001F,
/// U+007F..009F), line separators (U+2028, U+2029) and bidirectional marks (U+061C, U+200E, U+200F, U+202A..202E,
/// U+2066..2069; Unicode Standard Annex 9), which show text in another order than it has.
std::string printable(std::string_view text);
/// The same, cut to the width in characters, padded with blanks.
std::string fitted(std::string_view text, std::size_t width);
/// The first character and what continues it, also where it is broken: at least one byte of a text that is not empty.
std::string_view first_character(std::string_view text);

}  // namespace rubicon::base
