#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace rubicon::base {

/// Why something the outside world asked for or sent did not work (never our own mistakes: those assert).
enum class ErrorCode {
  kInvalid,      ///< malformed: a frame, a file, a key, a value
  kNotFound,     ///< no such tuple, device, network, island, file
  kOutOfRange,   ///< well formed, but outside the permitted range
  kUnsupported,  ///< well formed, but this peer, device or type does not do that
  kRefused,      ///< not permitted (read-only, recorded device, hop limit, not the owner)
  kBusy,         ///< a bound is reached; try again later
  kExpired,      ///< its time to live ended first
  kDuplicate,    ///< already there, or two things claim one name
  kUnreachable,  ///< the line or the device is down
  kIo,           ///< the operating system said no
};

/// `invalid`, `not-found`, ...: the spelling in tuples, replies and logs.
std::string_view to_string(ErrorCode code);

/// What went wrong: a code for programs and a text for people that says what was being done to what.
struct Error {
  ErrorCode code = ErrorCode::kInvalid;
  std::string text;

  friend bool operator==(const Error&, const Error&) = default;
};

/// A value, or the reason there is none.
template <class T = void>
class [[nodiscard]] Result : public tl::expected<T, Error> {
 public:
  using tl::expected<T, Error>::expected;
  Result(tl::expected<T, Error> other) : tl::expected<T, Error>(std::move(other)) {}
};

/// `return fail(ErrorCode::kInvalid, "...")` from any function that returns a Result.
inline tl::unexpected<Error> fail(ErrorCode code, std::string text) {
  return tl::unexpected<Error>(Error{code, std::move(text)});
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
