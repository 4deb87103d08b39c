#include "transport/mosquitto_faults.h"

#include <fmt/format.h>
#include <mosquitto.h>
#include <netdb.h>

#include <cerrno>
#include <string_view>
#include <system_error>

#include "model/findings.h"

namespace rubicon::transport {

namespace findings = model::findings;

Error MosquittoFaults::of_connect(int result, int error) const {
  if (auto fault = of_tls()) return *fault;
  if (result == MOSQ_ERR_TLS || (result == MOSQ_ERR_ERRNO && error == EPROTO)) return closed();
  auto text = fmt::format("cannot connect: {}", ::mosquitto_strerror(result));
  std::string_view finding;
  if (result == MOSQ_ERR_ERRNO) text = "cannot connect: " + std::generic_category().message(error);
  if (result == MOSQ_ERR_ERRNO && error == ECONNREFUSED) finding = findings::kConnectionRefused;
  if (result == MOSQ_ERR_EAI) {
    text = fmt::format("host {} cannot be found: {}", options_.host, ::gai_strerror(error));
    finding = findings::kHostUnknown;
  }
  return {ErrorCode::kUnreachable, fmt::format("{}: {}", name_, text), finding};
}

Error MosquittoFaults::closed() const {
  if (accepted) return {ErrorCode::kUnreachable, name_ + ": the broker closed the connection"};
  return {ErrorCode::kUnreachable,
          fmt::format("{}: the broker closed the connection before it answered ({})", name_,
                      options_.tls ? "does it speak TLS, does it want our certificate?" : "does it expect TLS?"),
          options_.tls ? findings::kTlsEnds : findings::kTlsExpected};
}

std::optional<Error> MosquittoFaults::of_tls() const {
  if (tls == nullptr) return std::nullopt;
  if (!tls->fault().empty()) {
    const auto& expected = options_.tls->server_name.empty() ? options_.host : options_.tls->server_name;
    return Error{ErrorCode::kRefused,
                 fmt::format("{}: the certificate of the broker is not accepted: {} (expected {})", name_, tls->fault(),
                             expected),
                 tls->finding()};
  }
  // `OpenSSL Error[0]: error:0A00010B:SSL routines::wrong version number`. The end of a connection is not a TLS error.
  if (complaint.empty() || complaint.find("unexpected eof") != std::string::npos) return std::nullopt;
  const auto why = complaint.substr(complaint.rfind(':') + 1);
  return Error{ErrorCode::kRefused, fmt::format("{}: TLS failed: {}", name_, why), findings::kTlsFailed};
}

Error MosquittoFaults::no_answer(const char* to) const {
  return {ErrorCode::kUnreachable, fmt::format("{}: the broker does not answer {}", name_, to),
          findings::kBrokerSilent};
}

Error MosquittoFaults::of_end(int result, int error) const {
  if (reason >= 0x80) return mqtt_error(reason, name_);
  if (auto fault = of_tls()) return *fault;
  switch (result) {
    case MOSQ_ERR_KEEPALIVE:
      return {ErrorCode::kUnreachable, name_ + ": the broker does not answer", findings::kBrokerSilent};
    case MOSQ_ERR_SUCCESS:
    case MOSQ_ERR_CONN_LOST:
    case MOSQ_ERR_NO_CONN:
    case MOSQ_ERR_TLS: return closed();
    case MOSQ_ERR_ERRNO:
      if (error == 0 || error == EPROTO) return closed();
      return {ErrorCode::kUnreachable,
              fmt::format("{}: the connection is lost: {}", name_, std::generic_category().message(error))};
    default:
      return {ErrorCode::kInvalid,
              fmt::format("{}: the broker breaks the protocol: {}", name_, ::mosquitto_strerror(result))};
  }
}

}  // namespace rubicon::transport
