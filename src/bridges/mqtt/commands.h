#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "base/limited_log.h"
#include "bridges/mqtt/house.h"
#include "client/remote_set_tracker.h"
#include "transport/mqtt.h"

namespace rubicon::bridges::mqtt {

/// Takes commands from topics `.../set`: asks whether the bridge may, sets the tuple, and publishes what became of it.
/// A command that was retained is older than we are, and ignored.
class Commands {
 public:
  static constexpr std::size_t kMaxUnderWay = 1000;
  static constexpr std::size_t kMaxText = std::size_t{64} << 10U;  ///< of a command, in bytes
  static constexpr Duration kTimeToLive = std::chrono::seconds(5), kMaxToLive = std::chrono::hours(24);

  struct Calls {
    std::function<void(transport::MqttPublication)> publish;
    /// A command did not succeed: whoever showed its value already is told the present one again.
    std::function<void(const std::string& topic)> correct;
  };
  Commands(const BridgeHost& host, const Options& options, House& house, Calls calls)
      : host_(host),
        options_(options),
        house_(house),
        calls_(std::move(calls)),
        log_({host.log, "bridge " + host.name}, host.scheduler) {}

  void take(const transport::MqttMessage& message);
  std::uint64_t taken() const { return taken_; }
  std::uint64_t refused() const { return refused_; }
  std::size_t under_way() const { return under_way_.size(); }

 private:
  /// Where the answer goes.
  struct Way {
    std::string topic;  ///< of the point
    std::string response, correlation;
  };
  Result<PointEntry*> check(const transport::MqttMessage& message, std::string_view topic) const;
  Result<void> may(const tuples::RemoteSet& set, std::string_view sender) const;
  void send(const PointEntry& point, const transport::MqttMessage& message, Way way);
  void answer(const Way& way, const client::Outcome& outcome);

  struct Running {
    std::unique_ptr<client::RemoteSetTracker> tracker;
    Handle spoken_for;
  };
  const BridgeHost& host_;
  const Options& options_;
  House& house_;
  Calls calls_;
  base::LimitedLog log_;
  std::list<Running> under_way_;
  std::uint64_t taken_ = 0, refused_ = 0;
};

}  // namespace rubicon::bridges::mqtt
