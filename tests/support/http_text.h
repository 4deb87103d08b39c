#pragma once

#include <string>

namespace rubicon::support {

/// The whole answer of a server at 127.0.0.1 to a request such as `GET /healthz`; `fields` are header lines that end
/// with \r\n. Empty if no server listens.
std::string http_text(int port, const std::string& request, const std::string& fields = {});

}  // namespace rubicon::support
