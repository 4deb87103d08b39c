#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace rubicon::base {

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

}  // namespace rubicon::base
