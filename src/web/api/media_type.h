#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::web::api {

/// The media type of a Content-Type field (RFC 9110, section 8.3), without parameters, in lower case. kInvalid for what
/// is none.
Result<std::string> media_type_of(std::string_view field);

/// What a browser may be given of a value that any component wrote: media types that cannot run scripts as they are,
/// all others as bytes.
struct SafeType {
  std::string media_type;
  bool is_shown = false;  ///< false: the browser has to save it to a file
};
SafeType safe_type(std::string_view media_type);

}  // namespace rubicon::web::api
