#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace rubicon::base {

/// Removes the next character of a text in UTF-8 (RFC 3629) and returns it. nullopt, with one byte removed, if the text
/// does not begin with a well-formed one: overlong forms, surrogates and what is above U+10FFFF are not. nullopt for an
/// empty text.
std::optional<char32_t> take_utf8(std::string_view& text);

/// Appends a character in UTF-8; U+FFFD for what is none: surrogates and what is above U+10FFFF. The characters of
/// ISO 8859-1 are U+0000 to U+00FF, so that its bytes can be passed as they are.
void append_utf8(char32_t character, std::string& out);

}  // namespace rubicon::base
