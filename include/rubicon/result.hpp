#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace rubicon::base {

/// Why an operation on input from outside failed. Errors of this program itself are assertions.
enum class ErrorCode {
  kInvalid,      ///< malformed frame, file, key or value
  kNotFound,     ///< no such tuple, device, network, island, file
  kOutOfRange,   ///< well formed, but outside the permitted range
  kUnsupported,  ///< well formed, but this peer, device or type does not support it
  kRefused,      ///< not permitted (read-only, recorded device, hop limit, not the owner)
  kBusy,         ///< a limit is reached; try again later
  kExpired,      ///< the time to live ended first
  kDuplicate,    ///< exists already, or two things claim one name
  kUnreachable,  ///< the line or the device is down
  kIo,           ///< the operating system reported an error
};

/// `invalid`, `not-found`, ...: as written in tuples, replies and logs.
std::string_view to_string(ErrorCode code);

/// A failure: a code for programs, and a text for people that names the operation and its object.
struct Error {
  ErrorCode code = ErrorCode::kInvalid;
  std::string text;
  /// For programs that know a remedy (`rubicon doctor`): a word of model/findings.h; empty = there is none. A literal.
  std::string_view finding{};

  friend bool operator==(const Error&, const Error&) = default;
};

/// A value, or the error that prevented it.
template <class T = void>
class [[nodiscard]] Result : public tl::expected<T, Error> {
 public:
  using tl::expected<T, Error>::expected;
  Result(tl::expected<T, Error> other) : tl::expected<T, Error>(std::move(other)) {}
};

/// `return fail(ErrorCode::kInvalid, "...")` from any function that returns a Result.
inline tl::unexpected<Error> fail(ErrorCode code, std::string text, std::string_view finding = {}) {
  return tl::unexpected<Error>(Error{code, std::move(text), finding});
}
inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace rubicon::base

namespace rubicon {
using base::Error;
using base::ErrorCode;
using base::fail;
using base::Result;
}  // namespace rubicon
