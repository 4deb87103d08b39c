#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "web/exchange.h"

namespace rubicon::web::server {

/// The target of a request (RFC 9112, section 3.2): a path, its query, and the authority of the absolute form.
struct Target {
  std::string path;       ///< begins with `/`; as it was sent
  Fields query;           ///< decoded, valid UTF-8
  std::string authority;  ///< empty in the origin form
};

/// kInvalid for anything but the origin form and the absolute form, for wrong percent-encoding, and for what is not
/// UTF-8 or holds control characters when decoded.
Result<Target> parse_target(std::string_view text);

/// Percent-encoding (RFC 3986, section 2.1); nullopt if an escape is wrong, or if the result is not UTF-8 or holds
/// control characters.
std::optional<std::string> percent_decoded(std::string_view text);

}  // namespace rubicon::web::server
