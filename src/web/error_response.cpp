#include "web/error_response.h"

#include "model/json_members.h"

namespace rubicon::web {

namespace {

unsigned status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kNotFound: return 404;
    case ErrorCode::kRefused: return 403;
    case ErrorCode::kUnsupported: return 501;
    case ErrorCode::kBusy: return 429;
    case ErrorCode::kDuplicate: return 409;
    case ErrorCode::kUnreachable: return 503;
    case ErrorCode::kExpired: return 504;
    case ErrorCode::kIo: return 500;
    case ErrorCode::kInvalid:
    case ErrorCode::kOutOfRange: break;
  }
  return 400;
}

}  // namespace

Response error_response(unsigned status, ErrorCode code, std::string_view text) {
  return {.status = status,
          .content_type = "application/json",
          .body = model::dump({{"error", {{"code", to_string(code)}, {"text", text}}}})};
}

Response error_response(const Error& error) {
  return error_response(status_of(error.code), error.code, error.text);
}

Response refusal_of(const Error& error) {
  auto response = error_response(error.code == ErrorCode::kBusy ? 429 : 401, error.code, error.text);
  if (error.code == ErrorCode::kBusy) {
    response.headers.emplace_back("Retry-After", "60");
  } else {
    response.headers.emplace_back("WWW-Authenticate", "Bearer");
  }
  return response;
}

}  // namespace rubicon::web
