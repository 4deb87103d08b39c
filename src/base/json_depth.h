#pragma once

#include <cstddef>
#include <string_view>

namespace rubicon::base {

/// Whether brackets outside strings nest in more than `levels` levels. Checked before a text from outside is parsed, it
/// bounds the recursion over the tree. The text need not be valid JSON.
bool is_nested_deeper(std::string_view json, std::size_t levels);

}  // namespace rubicon::base
