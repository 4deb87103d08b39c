#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/log.h"
#include "bridges/command_desk.h"
#include "bridges/house.h"
#include "bridges/mqtt/mqtt_bridge.h"
#include "transport/mqtt.h"

namespace rubicon::bridges::mqtt {

/// Takes commands from topics `.../set`: asks whether the bridge may, sets the tuple, and publishes what became of it.
/// A command that was retained is older than we are, and ignored.
class Commands {
 public:
  static constexpr Duration kMaxToLive = std::chrono::hours(24);

  struct Callbacks {
    std::function<void(transport::MqttPublication)> publish;
    /// A command did not succeed: receivers that already show its value get the present value again.
    std::function<void(const std::string& topic)> correct;
  };
  Commands(const BridgeHost& host, const Options& options, House& house, Callbacks calls)
      : options_(options),
        house_(house),
        desk_(host, options),
        callbacks_(std::move(calls)),
        log_({host.log, "bridge " + host.name}, host.scheduler) {}

  void take(const transport::MqttMessage& message);
  std::uint64_t taken() const { return taken_; }
  std::uint64_t refused() const { return refused_; }

 private:
  /// Where the answer goes.
  struct Way {
    std::string topic;  ///< of the point
    std::string response, correlation;
  };
  Result<PointEntry*> check(const transport::MqttMessage& message, std::string_view topic) const;
  void send(const PointEntry& point, const transport::MqttMessage& message, Way way);
  Result<void> send_parts(const PointEntry& siren, const transport::MqttMessage& message, const nlohmann::json& object);
  void refuse(const Way& way, const Error& why);
  void answer(const Way& way, const client::Outcome& outcome);

  const Options& options_;
  House& house_;
  CommandDesk desk_;
  Callbacks callbacks_;
  base::LimitedLog log_;
  std::uint64_t taken_ = 0, refused_ = 0;
};

}  // namespace rubicon::bridges::mqtt
