#include "web/server/tls.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <unistd.h>

#include <boost/asio/ssl/context.hpp>
#include <cerrno>
#include <ctime>
#include <string_view>
#include <system_error>

namespace rubicon::web::server {

namespace {

/// What OpenSSL said last about a file, which is the least technical.
tl::unexpected<Error> file_error(std::string_view option, const std::string& path) {
  if (::access(path.c_str(), R_OK) != 0) {
    const int error = errno;
    return fail(error == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
                fmt::format("{} {}: cannot read: {}", option, path, std::generic_category().message(error)));
  }
  const char* reason = ::ERR_reason_error_string(::ERR_peek_last_error());
  ::ERR_clear_error();
  return fail(ErrorCode::kInvalid, fmt::format("{} {}: {}", option, path, reason == nullptr ? "not usable" : reason));
}

/// OpenSSL's own callback asks at the terminal and blocks.
int refuse_passphrase(char*, int, int, void*) {
  return 0;
}

WallTime end_of(const X509* certificate) {
  std::tm time{};
  if (certificate == nullptr || ::ASN1_TIME_to_tm(::X509_get0_notAfter(certificate), &time) != 1) return {};
  return std::chrono::floor<WallTime::duration>(std::chrono::system_clock::from_time_t(::timegm(&time)));
}

}  // namespace

Result<TlsSetup> read_tls(const TlsFiles& files) {
  // At the end of the process a thread may still be in the library.
  [[maybe_unused]] static const int once = ::OPENSSL_init_ssl(OPENSSL_INIT_NO_ATEXIT, nullptr);
  auto context = std::make_shared<boost::asio::ssl::context>(boost::asio::ssl::context::tls_server);
  auto* native = context->native_handle();
  SSL_CTX_set_min_proto_version(native, TLS1_2_VERSION);
  SSL_CTX_set_mode(native, SSL_MODE_RELEASE_BUFFERS);
  ::SSL_CTX_set_options(native, SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  ::SSL_CTX_set_default_passwd_cb(native, refuse_passphrase);
  ::ERR_clear_error();
  if (::SSL_CTX_use_certificate_chain_file(native, files.certificate.c_str()) != 1)
    return file_error("certificate", files.certificate);
  if (::SSL_CTX_use_PrivateKey_file(native, files.key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      ::SSL_CTX_check_private_key(native) != 1)
    return file_error("key", files.key);
  const auto expires = end_of(::SSL_CTX_get0_certificate(native));
  return TlsSetup{std::move(context), expires};
}

}  // namespace rubicon::web::server
