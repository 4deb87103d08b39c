#pragma once

#include <string_view>

namespace rubicon::base {

/// `*` stands for any text, `?` for any one byte; everything else for itself. Linear in the text for each `*`.
bool glob_matches(std::string_view pattern, std::string_view text);

}  // namespace rubicon::base
