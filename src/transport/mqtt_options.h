#pragma once

#include <string>
#include <vector>

#include "base/config_reader.h"
#include "transport/mqtt.h"
#include "transport/transports.h"

namespace rubicon::transport {

/// A broker as a configuration names it. The password itself is read when a line is opened.
struct MqttBrokerOptions {
  /// A file that an option names, with its resolved path.
  struct File {
    std::string option, path;
  };

  MqttOptions line;                              ///< without password, client id and will
  std::string password_file, password_variable;  ///< at most one of them

  /// The options of a line with the password. kNotFound or kIo if there is no such file, kNotFound if the environment
  /// variable is not set, kInvalid if there is no password in it.
  Result<MqttOptions> with_password(Transports& transports) const;
  /// What is wrong with the permissions of the password file; empty if only its owner can read it, or there is none.
  std::string password_warning(Transports& transports) const;
  /// What must exist for a line.
  std::vector<File> files() const;
};

/// Reads the option `broker`: `HOST[:PORT]`, or a map {host, port, tls: yes | {ca, certificate, key, server-name},
/// user, password-file | password-env, version: any | 5 | 3.1.1, largest-packet}. Port: 1883, with TLS 8883. Reports
/// every error to the reader, also that the option is missing. Relative paths start at `directory`.
MqttBrokerOptions read_mqtt_broker(ConfigReader& options, const std::string& directory,
                                   const std::string& key = "broker");

}  // namespace rubicon::transport
