#include "transport/mqtt_tls.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <limits>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include "model/findings.h"

namespace rubicon::transport {

namespace {

SSL_CTX* as_context(void* context) {
  return static_cast<SSL_CTX*>(context);
}

/// The last thing that OpenSSL says about a file, which is the least technical.
auto tls_error(std::string_view option, const std::string& path) {
  if (::access(path.c_str(), R_OK) != 0) {
    const int error = errno;
    const auto code = error == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
    return fail(code, fmt::format("{} {}: cannot read: {}", option, path, std::generic_category().message(error)));
  }
  const char* reason = ::ERR_reason_error_string(::ERR_peek_last_error());
  ::ERR_clear_error();
  return fail(ErrorCode::kInvalid, fmt::format("{} {}: {}", option, path, reason == nullptr ? "not usable" : reason));
}

std::string_view finding_of(int code) {
  namespace findings = model::findings;
  switch (code) {
    case X509_V_ERR_CERT_HAS_EXPIRED: return findings::kCertificateExpired;
    case X509_V_ERR_CERT_NOT_YET_VALID: return findings::kCertificateEarly;
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH: return findings::kCertificateName;
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY: return findings::kCertificateAuthority;
    default: return findings::kCertificateBad;
  }
}

int keep_verify_fault(int accepted, X509_STORE_CTX* store) {
  if (accepted == 1) return 1;
  auto* ssl = static_cast<SSL*>(::X509_STORE_CTX_get_ex_data(store, ::SSL_get_ex_data_X509_STORE_CTX_idx()));
  auto* self = static_cast<MqttTlsContext*>(SSL_CTX_get_app_data(::SSL_get_SSL_CTX(ssl)));
  self->set_fault(::X509_STORE_CTX_get_error(store));
  return 0;
}

/// OpenSSL's own callback asks at the terminal and blocks.
int note_that_key_is_encrypted(char*, int, int, void* encrypted) {
  *static_cast<bool*>(encrypted) = true;
  return 0;
}

Result<void> read_key(SSL_CTX* context, const std::string& path) {
  bool encrypted = false;
  ::SSL_CTX_set_default_passwd_cb(context, note_that_key_is_encrypted);
  ::SSL_CTX_set_default_passwd_cb_userdata(context, &encrypted);
  const bool read = ::SSL_CTX_use_PrivateKey_file(context, path.c_str(), SSL_FILETYPE_PEM) == 1;
  ::SSL_CTX_set_default_passwd_cb_userdata(context, nullptr);
  if (encrypted) {
    ::ERR_clear_error();
    return fail(ErrorCode::kInvalid, fmt::format("key {}: is encrypted, expected a key without a passphrase", path));
  }
  if (!read || ::SSL_CTX_check_private_key(context) != 1) return tls_error("key", path);
  return {};
}

bool expect_name(SSL_CTX* context, const std::string& name) {
  auto* parameters = ::SSL_CTX_get0_param(context);
  ::X509_VERIFY_PARAM_set_hostflags(parameters, X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS);
  return ::X509_VERIFY_PARAM_set1_ip_asc(parameters, name.c_str()) == 1 ||
         ::X509_VERIFY_PARAM_set1_host(parameters, name.c_str(), name.size()) == 1;
}

}  // namespace

void MqttTlsContext::set_fault(int code) {
  fault_ = ::X509_verify_cert_error_string(code);
  finding_ = finding_of(code);
}

MqttTlsContext::~MqttTlsContext() {
  ::SSL_CTX_free(as_context(context_));
}

Result<std::unique_ptr<MqttTlsContext>> MqttTlsContext::make(const MqttTls& tls, const std::string& host) {
  // At the end of the process a thread may still be in the library.
  [[maybe_unused]] static const int once = ::OPENSSL_init_ssl(OPENSSL_INIT_NO_ATEXIT, nullptr);
  auto made = std::make_unique<MqttTlsContext>();
  made->context_ = ::SSL_CTX_new(::TLS_client_method());
  if (made->context_ == nullptr) return fail(ErrorCode::kIo, "TLS: no memory");
  if (auto sound = made->read(tls, host); !sound) return fail(sound.error());
  return made;
}

Result<void> MqttTlsContext::read(const MqttTls& tls, const std::string& host) {
  auto* context = as_context(context_);
  SSL_CTX_set_app_data(context, this);
  ::SSL_CTX_set_verify(context, SSL_VERIFY_PEER, keep_verify_fault);
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_mode(context,
                   SSL_MODE_RELEASE_BUFFERS | SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  const auto& name = tls.server_name.empty() ? host : tls.server_name;
  if (!expect_name(context, name)) return fail(ErrorCode::kInvalid, "TLS: no name to expect: " + name);
  if (tls.ca_file.empty()) {
    ::SSL_CTX_set_default_verify_paths(context);
  } else if (::SSL_CTX_load_verify_file(context, tls.ca_file.c_str()) != 1) {
    return tls_error("ca", tls.ca_file);
  }
  if (tls.certificate_file.empty()) return {};
  if (::SSL_CTX_use_certificate_chain_file(context, tls.certificate_file.c_str()) != 1)
    return tls_error("certificate", tls.certificate_file);
  return read_key(context, tls.key_file);
}

std::ptrdiff_t tls_write(void* ssl, std::string_view bytes) {
  auto* to = static_cast<SSL*>(ssl);
  ::ERR_clear_error();
  const int length = static_cast<int>(std::min<std::size_t>(bytes.size(), std::numeric_limits<int>::max()));
  const int count = ::SSL_write(to, bytes.data(), length);
  if (count > 0) return count;
  const int why = ::SSL_get_error(to, count);
  errno = why == SSL_ERROR_WANT_WRITE || why == SSL_ERROR_WANT_READ ? EAGAIN : EPROTO;
  return -1;
}

Result<std::string> certificate_name(const std::string& file) {
  const std::unique_ptr<SSL_CTX, decltype(&::SSL_CTX_free)> context(::SSL_CTX_new(::TLS_client_method()),
                                                                    ::SSL_CTX_free);
  if (!context || ::SSL_CTX_use_certificate_chain_file(context.get(), file.c_str()) != 1)
    return tls_error("certificate", file);
  std::array<char, 256> name{};
  auto* subject = ::X509_get_subject_name(::SSL_CTX_get0_certificate(context.get()));
  const auto size = ::X509_NAME_get_text_by_NID(subject, NID_commonName, name.data(), static_cast<int>(name.size()));
  if (size > 0) return std::string(name.data(), static_cast<std::size_t>(size));
  return fail(ErrorCode::kInvalid, file + ": the certificate has no common name (CN)");
}

}  // namespace rubicon::transport
