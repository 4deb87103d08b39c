#include <cstdio>
#include <cstdlib>

#include "base/assert.h"
#include "rubicon/result.hpp"

namespace rubicon::base {

std::string_view to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalid: return "invalid";
    case ErrorCode::kNotFound: return "not-found";
    case ErrorCode::kOutOfRange: return "out-of-range";
    case ErrorCode::kUnsupported: return "unsupported";
    case ErrorCode::kRefused: return "refused";
    case ErrorCode::kBusy: return "busy";
    case ErrorCode::kExpired: return "expired";
    case ErrorCode::kDuplicate: return "duplicate";
    case ErrorCode::kUnreachable: return "unreachable";
    case ErrorCode::kIo: return "io";
  }
  return "unknown";
}

void assertion_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: assertion failed: %s\n", file, line, condition);
  std::abort();
}

}  // namespace rubicon::base
