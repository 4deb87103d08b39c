#pragma once

#include <functional>
#include <optional>
#include <string>

#include "base/deadline.h"

namespace rubicon::networks::zigbee::device {

/// The limit for the silence of a device whose availability Zigbee2MQTT does not publish (zigbee.md, section 6). A
/// device that can be asked is asked before, because many report only changes.
class Silence {
 public:
  /// For the answer to a question whether the device is there.
  static constexpr Duration kProbeTime = std::chrono::seconds(15);

  struct Calls {
    std::function<bool()> ask;  ///< false: no place in this moment
    std::function<void(std::string reason)> unreachable;
  };
  Silence(Scheduler& scheduler, Calls calls);

  /// nullopt: no limit.
  void limit(std::optional<Duration> limit, bool can_ask);
  /// The device was heard, so long ago.
  void heard(Duration ago);
  /// Its silence counts from now on; false: the line is down.
  void line(bool up);

 private:
  enum class Phase : std::uint8_t { kHeard, kAsked, kUnreachable };
  void due();
  void schedule();

  Scheduler& scheduler_;
  Calls calls_;
  std::optional<Duration> limit_;
  bool can_ask_ = false, up_ = false;
  Phase phase_ = Phase::kHeard;
  SteadyTime heard_at_{};
  base::Deadline deadline_;
};

}  // namespace rubicon::networks::zigbee::device
