#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace rubicon::networks::knx::dpt {

/// The next character of UTF-8 text, which is taken from it; nullopt (and one byte taken) where it is no UTF-8.
std::optional<char32_t> take_character(std::string_view& text);
/// Appends a character below U+10000 as UTF-8.
void append_character(char32_t character, std::string& out);

}  // namespace rubicon::networks::knx::dpt
