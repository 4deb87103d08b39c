#pragma once

#include <functional>
#include <optional>
#include <queue>
#include <vector>

#include "base/deadline.h"
#include "proxy/tuple_mirror.h"

namespace rubicon::proxy {

/// Notices silence: devices not heard for the network's silence become unreachable, values older than their deadline
/// stale. One heap entry a device and one timer in all: a reading only notes the time, the look at the deadline finds
/// out whether anything is due.
class Liveness {
 public:
  struct Calls {
    std::function<void(Device&)> stale;  ///< some of its values just became so
    std::function<void(Device&)> lost;   ///< it is unreachable from now on
    std::function<void(Device&)> probe;  ///< it is to be asked whether it is there
  };
  Liveness(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Calls calls);

  /// A point became good, a device reachable, or a rule changed: look at the device in time.
  void watch(Device& device);
  /// Values seen before an interruption say nothing about what happened during it.
  void interrupted(Device& device, const std::string& reason);

 private:
  struct Check {
    SteadyTime when;
    DeviceNumber device;
    bool operator>(const Check& other) const { return when > other.when; }
  };
  void arm(Device& device, SteadyTime when);
  void set_timer();
  void look_at_due();
  void look(Device& device, SteadyTime now);
  std::optional<SteadyTime> next_look(const Device& device) const;

  ProxyContext& context_;
  DeviceDirectory& directory_;
  TupleMirror& mirror_;
  Calls calls_;
  std::priority_queue<Check, std::vector<Check>, std::greater<>> checks_;
  base::Deadline next_check_;
};

/// When a device is asked whether it is there, where that can be asked: at once if it is only remembered, after half
/// the silence period of a quiet one and, if it does not answer, after three quarters; then each half period. nullopt =
/// not now.
std::optional<SteadyTime> probe_at(const Device& device);

/// When a good value becomes stale; nullopt = never. The rule is in docs/tuple-keys.md, "Deadlines".
std::optional<SteadyTime> stale_at(const Device& device, const Point& point);

}  // namespace rubicon::proxy
