#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "support/process.h"

namespace rubicon::support {

/// Certificates of a made-up authority, made by openssl: for a broker called `broker.test` and for a client; `other_ca`
/// signed none of them.
class Certificates {
 public:
  Certificates();
  ~Certificates();
  Certificates(const Certificates&) = delete;
  Certificates& operator=(const Certificates&) = delete;

  /// Path of `ca.pem`, `other_ca.pem`, `server.pem`, `server.key`, `client.pem`, `client.key`;
  /// the last one also encrypted: `encrypted.key`, `encrypted.pkcs8`.
  std::string path(const std::string& file) const { return folder_ + "/" + file; }
  /// Why there are none; empty if there are.
  const std::string& reason() const { return reason_; }

 private:
  std::string folder_, reason_;
};

struct MosquittoOptions {
  std::uint16_t port = 1883;
  std::map<std::string, std::string> users{};   ///< with passwords; empty = all users
  const Certificates* tls = nullptr;            ///< the port speaks TLS
  bool asks_for_certificate = false;            ///< of clients, signed by the authority
  std::string acl{};                            ///< text of an acl_file; mosquitto then drops messages silently
  std::vector<std::string> refused_filters{};   ///< answered by a refusal
  std::vector<std::string> forbidden_topics{};  ///< filters; publications are refused
  bool persistent = false;                      ///< retained messages survive stop() and restart(), not kill()
  std::string more{};                           ///< further lines of its configuration
};

/// A mosquitto (Debian's 2.0) on 127.0.0.1. To be made in a PrivateNetwork.
class Mosquitto {
 public:
  /// Why it cannot run: a program is missing. Empty = it can.
  static std::string missing();

  explicit Mosquitto(MosquittoOptions options = {});
  ~Mosquitto();
  Mosquitto(const Mosquitto&) = delete;
  Mosquitto& operator=(const Mosquitto&) = delete;

  /// It listens; to be asked until it does.
  bool ready() const;
  /// Waits until it listens, a minute at most.
  bool comes_up() const;
  /// Without a word, as at SIGKILL.
  void kill();
  /// In order, as at SIGTERM.
  void stop();
  void start();
  std::string errors() { return process_ ? process_->errors() : std::string(); }
  Process& process() { return *process_; }
  std::uint16_t port() const { return options_.port; }
  /// `mosquitto_pub -t TOPIC ...`, to its end; plain and without password.
  Outcome publish(const std::string& topic, const std::string& payload, std::vector<std::string> more = {}) const;

 private:
  std::string configuration() const;
  void write_users() const;
  void write_security() const;

  MosquittoOptions options_;
  std::string folder_;
  std::unique_ptr<Process> process_;
};

/// `mosquitto_sub -t FILTER -v`: what others see on a broker.
class MosquittoListener {
 public:
  /// Returns when its subscription is there.
  MosquittoListener(const Mosquitto& broker, const std::string& filter);

  /// The next message as `topic payload`; nullopt after a minute.
  std::optional<std::string> next();

 private:
  Process process_;
};

}  // namespace rubicon::support
