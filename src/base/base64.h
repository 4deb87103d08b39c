#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::base {

/// Base 64 with padding, on one line (RFC 4648, section 4).
std::string to_base64(std::string_view bytes);
/// kInvalid names the position of the first character that is wrong; padding is required, blanks are not allowed.
Result<std::string> from_base64(std::string_view text);

}  // namespace rubicon::base
