#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "model/message.h"
#include "network/network.h"
#include "networks/zigbee/bridge/messages.h"
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
  struct Callbacks {
    std::function<void()> connected;
    std::function<void(const transport::MqttMessage& message)> received;
    /// What publish() was asked for.
    std::function<void(std::string_view topic, std::string_view payload)> published{};
    /// A packet beyond `largest-packet` was dropped; with its length in bytes.
    std::function<void(std::string_view topic, std::size_t bytes)> too_long;
    /// An access list forbids a subscription.
    std::function<void(std::string_view filter, const Error& why)> forbidden;
    /// What unsubscribe() was asked for.
    std::function<void(std::string_view filter)> unsubscribed{};
    /// The broker took what was published there, or did not (version 5: PUBACK; README.md has the reasons).
    std::function<void(std::string_view topic)> taken;
    std::function<void(std::string_view topic, const Error& why)> not_taken;
    /// The connection is lost: for NetworkHost::failed().
    std::function<void(Error why)> lost;
    /// The broker refused us: refusal() and attempts() changed.
    std::function<void()> refused;
  };
  BrokerLine(network::NetworkHost& host, transport::MqttBrokerOptions options, Callbacks calls);

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
  const Error& refusal() const { return refusal_; }
  /// Attempts that this made by itself after refusals, and when the next one comes; zero = none is planned.
  std::uint64_t attempts() const { return attempts_; }
  WallTime next_attempt() const { return next_attempt_; }
  /// Of all connections together.
  transport::MqttCounters counters() const;

 private:
  transport::MqttCallbacks line_calls();
  void failed(Error why);
  void drop_line();
  void wait();
  void retry();
  void warn_of_password();

  network::NetworkHost& host_;
  transport::MqttBrokerOptions options_;
  Callbacks callbacks_;
  bool connected_ = false;
  bool warned_ = false;  ///< of the permissions of the password file
  Error refusal_;
  std::uint64_t attempts_ = 0;
  WallTime next_attempt_{};
  Timer retry_;
  transport::MqttCounters before_{};  ///< of earlier connections
  std::unique_ptr<transport::MqttLine> line_;
};

/// Whether Zigbee2MQTT is there and can be used: what `bridge/state` and `bridge/info` say on a connection to the
/// broker (zigbee.md, section 2).
class BridgeState {
 public:
  /// How long the retained `bridge/state` may take after a connect, and `bridge/info` after `online`. A broker that
  /// was restarted without persistence has no `bridge/info`.
  static constexpr Duration kStateTime = std::chrono::seconds(5), kInfoTime = std::chrono::seconds(2);
  /// Two messages `online` within this time are one that arrived twice (QoS 1).
  static constexpr Duration kRepetition = std::chrono::seconds(1);

  /// `changed` is called at each change, and when the bridge was started again without having been offline.
  BridgeState(Scheduler& scheduler, const std::string& base, std::function<void()> changed);

  void connected();
  void lost(const std::string& why);
  /// A payload of `bridge/state`. `retained`: the broker kept it, so the bridge did not start just now.
  Result<void> state(std::string_view payload, bool retained);
  /// Whether the bridge or the broker was started again: old states may be published as if they were new.
  bool repeats() const { return started_ || connections_ > 1; }
  void info(bridge::BridgeDescription info);

  model::LineState line() const { return line_; }
  /// Why it is not up; empty = it is.
  const std::string& reason() const { return reason_; }
  /// False after a bridge/info of a version that we do not speak.
  bool supported() const { return unsupported_.empty(); }

 private:
  void decide();
  void set(model::LineState line, std::string reason);

  Scheduler& scheduler_;
  std::string base_;
  std::function<void()> changed_;
  model::LineState line_ = model::LineState::kConnecting;
  std::string reason_;
  std::optional<bool> online_;  ///< nullopt: not received on this connection
  SteadyTime online_since_{};
  bool started_ = false;  ///< the last `online` came live
  unsigned connections_ = 0;
  bool described_ = false;  ///< bridge/info came, on this connection or an earlier one
  std::string unsupported_;
  Timer patience_;
};

/// What is known of a line that is up.
struct LineFacts {
  std::string base;                     ///< topic of the bridge
  std::string user;                     ///< as which the broker knows us; empty = none
  std::set<std::string> forbidden;      ///< filters whose subscription the broker refused
  std::set<std::string> not_taken;      ///< topics to which it takes no messages of ours
  bool list_missing = false;            ///< no bridge/devices was received, although it is time
  bool others_came = false;             ///< another retained message of the bridge was received: bridge/groups
  bool retains = true;                  ///< false: mqtt.force_disable_retain
  std::optional<std::size_t> too_long;  ///< bytes of a bridge/devices that was dropped
  std::size_t largest_packet = 0;       ///< bytes that we take
  std::size_t silent_devices = 0;       ///< so many devices, and nothing of any of them for too long
};

/// What is wrong with a line that is up, the likely cause, and what to do; empty = nothing is. Of several troubles the
/// one that explains the others.
std::string line_trouble(const LineFacts& facts);

}  // namespace rubicon::networks::zigbee
