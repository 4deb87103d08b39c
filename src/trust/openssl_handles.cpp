#include "trust/openssl_handles.h"

#include <fmt/format.h>
#include <openssl/err.h>

#include <climits>

namespace rubicon::trust {

namespace {

/// Empty if OpenSSL has none.
std::string first_reason() {
  const auto code = ERR_get_error();
  const auto* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  ERR_clear_error();
  return reason == nullptr ? "" : reason;
}

}  // namespace

BioHandle reading(std::string_view text) {
  const auto size = text.size() > INT_MAX ? INT_MAX : static_cast<int>(text.size());
  return BioHandle(BIO_new_mem_buf(text.empty() ? "" : text.data(), size));
}

BioHandle writing() {
  return BioHandle(BIO_new(BIO_s_mem()));
}

std::string written_text(BIO* bio) {
  char* start = nullptr;
  const auto size = BIO_get_mem_data(bio, &start);
  return size <= 0 ? std::string() : std::string(start, static_cast<std::size_t>(size));
}

tl::unexpected<Error> openssl_failed(std::string_view operation) {
  const auto reason = first_reason();
  return fail(ErrorCode::kIo, fmt::format("OpenSSL cannot {}: {}", operation, reason.empty() ? "no reason" : reason));
}

tl::unexpected<Error> invalid_input(std::string_view where, std::string_view what) {
  const auto reason = first_reason();
  return fail(ErrorCode::kInvalid,
              reason.empty() ? fmt::format("{}: {}", where, what) : fmt::format("{}: {} ({})", where, what, reason));
}

}  // namespace rubicon::trust
