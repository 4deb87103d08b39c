#pragma once

#include <functional>
#include <optional>
#include <queue>
#include <vector>

#include "base/scheduler.h"
#include "proxy/tuple_mirror.h"

namespace rubicon::proxy {

/// Devices not heard for the network's `silence` become unreachable, values older than their deadline become stale.
/// Few heap entries per device and one timer for all: a reading only notes the time; the check at the deadline decides.
class Liveness {
 public:
  struct Callbacks {
    std::function<void(Device&)> stale;  ///< some of its values just became stale
    std::function<void(Device&)> lost;   ///< it just became unreachable
    std::function<void(Device&)> probe;  ///< send it a Probe
  };
  Liveness(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Callbacks callbacks);

  /// Schedules the next check of the device. Call when a point became good, the device reachable, or a rule changed.
  void watch(Device& device);
  /// The line or the device was interrupted: its good and assumed values become stale with this reason.
  void interrupted(Device& device, const std::string& reason);

 private:
  struct Check {
    SteadyTime when;
    DeviceNumber device;
    bool operator>(const Check& other) const { return when > other.when; }
  };
  void arm(Device& device, SteadyTime when);
  void drop_outdated();
  void set_timer();
  void check_due();
  void check(Device& device, SteadyTime now);
  std::optional<SteadyTime> next_check_of(const Device& device) const;

  ProxyContext& context_;
  DeviceDirectory& directory_;
  TupleMirror& mirror_;
  Callbacks callbacks_;
  std::priority_queue<Check, std::vector<Check>, std::greater<>> checks_;
  base::Deadline next_check_;
};

/// When a device is probed, in networks that can: at once if it is only remembered; a quiet one after half the silence
/// period and, without an answer, after three quarters; then each half period. nullopt = not now.
std::optional<SteadyTime> probe_at(const Device& device);

/// When a good value becomes stale; nullopt = never. The rule is in docs/tuple-keys.md, "Deadlines".
std::optional<SteadyTime> stale_at(const Device& device, const Point& point);

}  // namespace rubicon::proxy
