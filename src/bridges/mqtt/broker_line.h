#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "base/log.h"
#include "base/scheduler.h"
#include "bridges/bridge.h"
#include "transport/mqtt_options.h"

namespace rubicon::bridges::mqtt {

/// The connection with the broker, which it opens again for ever, and what waits for a busy one.
class BrokerLine {
 public:
  static constexpr Duration kFirstPause = std::chrono::milliseconds(200), kMaxPause = std::chrono::seconds(1);
  /// After it refused us: a wrong password does not become right by repetition.
  static constexpr Duration kRefusedPause = std::chrono::seconds(30);
  /// It is busy after so many bytes at once: what a whole town announces need not lie in queues on both ways.
  static constexpr std::size_t kMaxBurst = std::size_t{128} << 10U;
  /// Of what waits in order.
  static constexpr std::size_t kMaxWaiting = 10'000, kMaxWaitingBytes = std::size_t{4} << 20U;

  struct Callbacks {
    std::function<void(const transport::MqttConnack&)> connected;
    std::function<void(const transport::MqttMessage&)> received;
    std::function<void()> roomy;  ///< after a busy(): it takes more
    std::function<void()> lost;   ///< it is opened again by itself
  };
  /// `will`: published by the broker when the connection is lost.
  BrokerLine(const BridgeHost& host, const transport::MqttBrokerOptions& options, transport::MqttWill will,
             Callbacks calls);

  void open();
  bool connected() const { return connected_; }
  void subscribe(const std::string& filter, std::uint8_t qos);
  void unsubscribe(const std::string& filter);
  /// False: it is busy, call again after `roomy`. What can never be sent is dropped, counted and named.
  bool publish(transport::MqttPublication publication);
  /// For what has no newer form (events, outcomes): waits for a busy line, up to kMaxWaiting. Beyond, and without a
  /// connection, it is dropped and counted.
  void publish_in_order(transport::MqttPublication publication);

  /// The last one before the end; what waits does not hold it back.
  void publish_last(transport::MqttPublication publication) {
    if (connected_) std::ignore = line_->publish(std::move(publication));
  }

  BridgeStatus status() const;

 private:
  transport::MqttCallbacks line_calls();
  Result<void> begin();
  void failed(const Error& why);
  bool is_burst(std::size_t bytes);
  void await_room();
  void go_on();
  bool drain();

  const BridgeHost& host_;
  const transport::MqttBrokerOptions& options_;
  transport::MqttWill will_;
  Callbacks callbacks_;
  base::LimitedLog log_;
  bool connected_ = false, refused_ = false;
  std::string reason_, limits_;
  Duration pause_ = kFirstPause;
  Timer retry_, room_;
  std::deque<transport::MqttPublication> waiting_;
  std::size_t waiting_bytes_ = 0;
  std::size_t burst_ = 0;  ///< bytes
  SteadyTime burst_began_{};
  std::uint64_t dropped_ = 0, connections_ = 0;
  std::set<std::string> forbidden_;  ///< filters and topics that the broker refuses
  transport::MqttCounters before_{};
  std::unique_ptr<transport::MqttLine> line_;
};

}  // namespace rubicon::bridges::mqtt
