#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/letter_case.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::knx::groups {

/// The encoding of a list. Mixed: UTF-8, with lines that are not UTF-8 and are read as Windows-1252.
enum class Encoding : std::uint8_t { kUtf8, kWindows1252, kMixed };

/// UTF-8 if all lines are; else mixed if a line has UTF-8 characters beyond ASCII or there is a byte order mark; else
/// Windows-1252.
Encoding encoding_of(std::string_view bytes);

/// How text in units of 16 bits is stored.
enum class Wide : std::uint8_t { kLittle, kBig };

/// Recognises UTF-16 by its byte order mark, else by the zero bytes that ASCII letters have in it. nullopt: it is not
/// UTF-16.
std::optional<Wide> utf16_of(std::string_view bytes);
/// The text in UTF-8, without a byte order mark. Half of a surrogate pair becomes U+FFFD. kInvalid: the last character
/// is cut off.
Result<std::string> from_utf16(std::string_view bytes, Wide form);

/// What a file of bytes that is no text seems to be, for an error: `UTF-32`, `a workbook of Excel`; empty = text.
std::string_view name_of_foreign(std::string_view bytes);

/// The code point of a byte of Windows-1252; the five unassigned bytes map to themselves (WHATWG Encoding).
std::uint16_t windows_1252(std::uint8_t byte);
/// Also for ISO-8859-1, as browsers do.
std::string from_windows_1252(std::string_view bytes);

/// Line breaks become `\n`, other control characters blanks; blanks at the ends are removed. Cut to `max_bytes`, never
/// within a character.
std::string clean_text(std::string_view utf8, std::size_t max_bytes);

using base::to_lower;

/// The byte order mark of UTF-8.
inline constexpr std::string_view kUtf8Mark = "\xef\xbb\xbf";

}  // namespace rubicon::networks::knx::groups
