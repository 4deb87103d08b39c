#pragma once

#include <string>
#include <string_view>

namespace rubicon::base {

/// The text with small letters in place of big ones of the Latin alphabets (Unicode: Basic Latin, Latin-1 Supplement,
/// Latin Extended-A without the letters between U+0138 and U+0148, which have other pairs). Invalid UTF-8 stays.
std::string to_lower(std::string_view utf8);

}  // namespace rubicon::base
