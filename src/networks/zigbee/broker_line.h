#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "network/network.h"
#include "transport/mqtt_options.h"

namespace rubicon::networks::zigbee {

/// The connection to the broker of Zigbee2MQTT. A lost one is opened again by the supervisor; after a refusal (user,
/// password, version) it waits kRefusedPause and tries again by itself, for ever.
class BrokerLine {
 public:
  /// A wrong password does not become right by repetition, and brokers lock out those who try often (mqtt.md, section
  /// 2, h).
  static constexpr Duration kRefusedPause = std::chrono::seconds(30);

  /// Called in turns of their own.
  struct Calls {
    std::function<void()> connected;
    std::function<void(const transport::MqttMessage& message)> received;
    /// A packet beyond `largest-packet` was dropped; with its length in bytes.
    std::function<void(std::string_view topic, std::size_t bytes)> too_long;
    /// An access list forbids a subscription.
    std::function<void(std::string_view filter, const Error& why)> forbidden;
    /// The broker took what was published there, or did not (version 5: PUBACK; README.md has the reasons).
    std::function<void(std::string_view topic)> taken;
    std::function<void(std::string_view topic, const Error& why)> not_taken;
    /// The connection is lost: for NetworkHost::failed().
    std::function<void(Error why)> lost;
    /// The broker refused us: refusal() and attempts() changed.
    std::function<void()> refused;
  };
  BrokerLine(network::NetworkHost& host, transport::MqttBrokerOptions options, Calls calls);

  /// Begins to connect; does nothing while it is open or waits after a refusal.
  Result<void> open();
  /// Ends the pause after a refusal: tries again in a later turn. False: there is no pause.
  bool reopen();
  /// Ends the connection by a DISCONNECT.
  void close();
  bool connected() const { return connected_; }

  // kUnreachable while not connected.
  Result<void> subscribe(std::string_view filter);
  Result<void> unsubscribe(std::string_view filter);
  /// With QoS 1, so that a broker of version 5 says what it does not take. It arrives once nevertheless: a client
  /// repeats nothing within a connection (MQTT 5, section 4.4), and each of ours is a new session.
  Result<void> publish(std::string topic, std::string payload);

  /// Why the broker does not accept us; empty = it did not refuse.
  const std::string& refusal() const { return refusal_; }
  /// Attempts that this made by itself after refusals, and when the next one comes; zero = none is planned.
  std::uint64_t attempts() const { return attempts_; }
  WallTime next_attempt() const { return next_attempt_; }
  /// Of all connections together.
  transport::MqttCounters counters() const;

 private:
  transport::MqttCalls line_calls();
  void failed(Error why);
  void drop_line();
  void wait();
  void retry();
  void warn_of_password();

  network::NetworkHost& host_;
  transport::MqttBrokerOptions options_;
  Calls calls_;
  bool connected_ = false;
  bool warned_ = false;  ///< of the permissions of the password file
  std::string refusal_;
  std::uint64_t attempts_ = 0;
  WallTime next_attempt_{};
  Timer retry_;
  transport::MqttCounters before_{};  ///< of earlier connections
  std::unique_ptr<transport::MqttLine> line_;
};

}  // namespace rubicon::networks::zigbee
