#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "support/mosquitto.h"
#include "support/private_network.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "zigbee/rig.h"

namespace rubicon::bench::zigbee {

/// mosquitto in a private network, and a loop for what connects to it. Says in `out` why there is none.
class RealRig {
 public:
  RealRig(Json& out, const std::string& what, bool persistent = false);

  explicit operator bool() const { return broker_.has_value(); }
  support::Mosquitto& broker() { return *broker_; }
  /// Waits until the broker accepts connections.
  void await_broker();
  transport::Loop& loop() { return loop_; }
  Scheduler& scheduler() { return loop_.scheduler(); }
  transport::LocalTransports& transports() { return transports_; }
  tuples::Ecology& ecology() { return ecology_; }
  void run(Duration span);
  /// Runs until it is so; throws with `what` after a minute.
  void run_until(const std::function<bool()>& done, const char* what);

  /// A connection that is never lost; host and port are the broker's.
  std::unique_ptr<transport::MqttLine> connect(std::function<void(const transport::MqttMessage&)> received,
                                               transport::MqttOptions options = {},
                                               std::function<void(std::string_view, std::size_t)> too_long = {});

 private:
  support::PrivateNetwork network_;
  std::optional<support::Mosquitto> broker_;
  transport::Loop loop_;
  transport::LocalTransports transports_{loop_};
  tuples::MemoryEcology ecology_{loop_.scheduler()};
};

/// The bridge is there, with these devices: retained.
void publish_bridge(transport::MqttLine& line, const std::string& list);

}  // namespace rubicon::bench::zigbee
