#pragma once

#include <cstdint>
#include <deque>
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

/// Time that advances only when a test advances it: hours pass in milliseconds, and each run is the same.
class VirtualScheduler final : public Scheduler {
 public:
  /// The wall clock starts at 2026-01-01T00:00:00Z.
  VirtualScheduler();

  SteadyTime now() const override { return now_; }
  WallTime wall_now() const override { return wall_; }
  void post(std::function<void()> call) override { posted_.push_back(std::move(call)); }
  Timer at(SteadyTime when, std::function<void()> call) override { return timers_.add(when, std::move(call)); }
  bool on_loop_thread() const override { return true; }

  /// Runs all calls that are due now, including those that they post.
  void run_ready();
  /// Advances the time by `span`, and runs each timer at its time.
  void run_for(Duration span);
  /// Advances the time and runs nothing, as while a process is stopped; what is due then runs late.
  void stop_for(Duration span) { advance_to(now_ + span); }
  /// `outside` is called when nothing is left to do; it waits briefly for real input, and returns true if that posted
  /// calls.
  void ask_outside(std::function<bool()> outside) { outside_ = std::move(outside); }
  /// Sets the wall clock, as an administrator or NTP would; monotonic time is untouched.
  void set_wall(WallTime wall) { wall_ = wall; }

 private:
  void advance_to(SteadyTime when);
  void run_posted();

  SteadyTime now_{};
  WallTime wall_{};
  Duration wall_rest_{};
  std::deque<std::function<void()>> posted_;
  TimerHeap timers_;
  std::function<bool()> outside_;
};

}  // namespace rubicon::base

namespace rubicon {

using base::VirtualScheduler;

}  // namespace rubicon
