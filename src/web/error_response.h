#pragma once

#include <string_view>

#include "rubicon/result.hpp"
#include "web/exchange.h"

namespace rubicon::web {

/// `{"error":{"code":"refused","text":...}}`.
Response error_response(unsigned status, ErrorCode code, std::string_view text);
/// The same for an error of the tree, with its status: invalid 400, not-found 404, refused 403, busy 429, unreachable
/// 503, expired 504.
Response error_response(const Error& error);
/// The answer to a token that was not accepted: 401 (RFC 6750, section 3), or 429 after too many.
Response refusal_of(const Error& error);

}  // namespace rubicon::web
