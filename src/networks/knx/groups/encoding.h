#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace rubicon::networks::knx::groups {

/// How the bytes of a list become text. Mixed: UTF-8, but lines that are none are read as Windows-1252.
enum class Encoding : std::uint8_t { kUtf8, kWindows1252, kMixed };

/// UTF-8 unless a line breaks it; then mixed if other lines are UTF-8 beyond ASCII (or a byte order mark says so),
/// Windows-1252 if none is.
Encoding encoding_of(std::string_view bytes);

/// The code point of a byte of Windows-1252; the five unassigned ones stand for their own number (WHATWG Encoding).
std::uint16_t windows_1252(std::uint8_t byte);
/// ISO-8859-1 is read as Windows-1252 too, as browsers do.
std::string from_windows_1252(std::string_view bytes);

/// Line breaks become `\n`, other control characters blanks; blanks at the ends go. Cut to `most` bytes between two
/// characters.
std::string clean_text(std::string_view utf8, std::size_t most);

/// Small letters: ASCII, Latin-1 and the pairs of Latin Extended-A; everything else stays.
std::string to_lower(std::string_view utf8);

/// The byte order mark of UTF-8.
inline constexpr std::string_view kUtf8Mark = "\xef\xbb\xbf";

}  // namespace rubicon::networks::knx::groups
