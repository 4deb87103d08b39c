#pragma once

#include <memory>
#include <set>
#include <string>

#include "apps/simulators/zigbee/world.h"
#include "transport/transports.h"

namespace rubicon::zigbee_simulator {

/// The connection of a World to a broker: connects, and again after each failure, with the will of a bridge. The world
/// starts with the first connection. While there is none, its messages are lost, as a real bridge loses them.
class BrokerLine {
 public:
  /// All must outlive it. `options`: where and as whom; the will is set here.
  BrokerLine(World& world, transport::MqttOptions options, Scheduler& scheduler, transport::Transports& transports,
             Log log);
  ~BrokerLine();
  BrokerLine(const BrokerLine&) = delete;
  BrokerLine& operator=(const BrokerLine&) = delete;

  /// Begins to connect. kInvalid for options that no broker can accept.
  Result<void> open();
  std::function<void()> started;  ///< after the first connection, once the world has started
  bool connected() const { return connected_; }
  std::uint64_t lost() const { return lost_; }

 private:
  void on_connected();
  void failed(const Error& why);
  void listen();
  void named(const std::string& name, bool used);
  void send(transport::MqttPublication publication);

  World& world_;
  transport::MqttOptions options_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  Log log_;
  std::unique_ptr<transport::MqttLine> line_;
  std::set<std::string> names_;
  bool connected_ = false, had_started_ = false;
  std::string last_error_;
  std::uint64_t lost_ = 0;  ///< messages that were not sent
  Timer again_;
};

}  // namespace rubicon::zigbee_simulator
