#pragma once

#include <string>

#include "rubicon/time.hpp"
#include "web/exchange.h"

namespace rubicon::web::server {

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
