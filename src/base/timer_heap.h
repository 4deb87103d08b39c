#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/scheduler.h"

namespace rubicon::base {

/// Pending timers ordered by time, then by age; shared by the virtual and the real scheduler.
/// Cancelled entries are removed once they outnumber the live ones, so that re-arming does not use up memory.
class TimerHeap {
 public:
  Timer add(SteadyTime when, std::function<void()> call);

  /// The time of the earliest live entry.
  std::optional<SteadyTime> next();

  /// Removes the earliest live entry if it is due at `now`, and returns its call; the Timer then is no longer pending.
  std::function<void()> take_due(SteadyTime now);

  std::size_t size() const { return heap_.size(); }

 private:
  struct Slot {
    SteadyTime when;
    std::uint64_t age;
    std::shared_ptr<Timer::Entry> entry;
  };
  static bool later(const Slot& a, const Slot& b);
  void drop_cancelled_front();
  void sweep();

  std::vector<Slot> heap_;
  std::uint64_t ages_ = 0;
  std::size_t sweep_at_ = 1024;
};

}  // namespace rubicon::base
