#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
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

/// How a response is framed (RFC 9112, section 6).
struct Framing {
  bool keep_alive = true;  ///< more requests may follow
  bool head_only = false;  ///< the answer to HEAD
  bool chunked = false;    ///< a stream, by HTTP/1.1
  bool secure = false;     ///< over TLS
};

/// Status line and fields, with those that protect the page in every response, up to the empty line. Fields whose name
/// or value could end a line are left out.
std::string head_text(const Response& response, const Framing& framing, WallTime now);

}  // namespace rubicon::web::server
