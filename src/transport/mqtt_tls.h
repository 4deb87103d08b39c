#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "transport/mqtt.h"

namespace rubicon::transport {

/// How OpenSSL checks the certificate of a broker: TLS 1.2 or later, the chain up to a known CA, the name or address.
/// The library of MQTT has settings for this too, but checks only the name that it connects to, and does not say what
/// is wrong.
class MqttTlsContext {
 public:
  /// Reads the files. kNotFound, kIo or kInvalid with the path.
  static Result<std::unique_ptr<MqttTlsContext>> make(const MqttTls& tls, const std::string& host);
  MqttTlsContext() = default;
  ~MqttTlsContext();
  MqttTlsContext(const MqttTlsContext&) = delete;
  MqttTlsContext& operator=(const MqttTlsContext&) = delete;

  /// An SSL_CTX.
  void* get() const { return context_; }
  /// Why the certificate was not accepted; empty if it was, or there was none yet.
  const std::string& fault() const { return fault_; }
  /// For it, as Error has it.
  std::string_view finding() const { return finding_; }
  /// For the callback of OpenSSL: a code of X509_STORE_CTX_get_error(3).
  void set_fault(int code);

 private:
  Result<void> read(const MqttTls& tls, const std::string& host);

  void* context_ = nullptr;
  std::string fault_;
  std::string_view finding_;
};

/// Writes to an SSL as send(2) does to a socket: -1 with EAGAIN if it takes nothing now, -1 with another errno if the
/// connection failed.
std::ptrdiff_t tls_write(void* ssl, std::string_view bytes);

/// The common name in a certificate (PEM): the user, for a broker that takes it for that. kNotFound, kIo or kInvalid
/// with the path.
Result<std::string> certificate_name(const std::string& file);

}  // namespace rubicon::transport
