#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace rubicon::networks::knx::dpt {

/// Removes the next UTF-8 character from the text and returns it; nullopt, with one byte removed, if it is not UTF-8.
std::optional<char32_t> take_character(std::string_view& text);
/// Appends a character below U+10000 as UTF-8.
void append_character(char32_t character, std::string& out);

}  // namespace rubicon::networks::knx::dpt
