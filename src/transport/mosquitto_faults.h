#pragma once

#include <optional>
#include <string>

#include "rubicon/result.hpp"
#include "transport/mqtt.h"
#include "transport/mqtt_tls.h"

namespace rubicon::transport {

/// What is known of a connection of libmosquitto, and what its end is called for people. The options must outlive it.
class MosquittoFaults {
 public:
  static constexpr int kNoReason = -1;

  explicit MosquittoFaults(const MqttOptions& options) : options_(options), name_(mqtt_name(options)) {}

  /// A result of the library that is no success, and errno: of connecting, and of an open connection.
  Error of_connect(int result, int error) const;
  Error of_end(int result, int error) const;
  /// What TLS complains about, if that is why the connection ended.
  std::optional<Error> of_tls() const;
  Error no_answer(const char* to) const;

  const MqttTlsContext* tls = nullptr;  ///< nullptr = without TLS
  bool accepted = false;                ///< the broker accepted the connection
  int reason = kNoReason;               ///< that the broker gave for the end; below 0x80 a code of the library
  std::string complaint;                ///< the first error in the library's log

 private:
  Error closed() const;

  const MqttOptions& options_;
  std::string name_;
};

}  // namespace rubicon::transport
