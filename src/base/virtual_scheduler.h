#pragma once

#include <deque>

#include "base/timer_heap.h"

namespace rubicon::base {

/// Time that moves only when a test says so: hours of a building's life in milliseconds, the same every run.
class VirtualScheduler final : public Scheduler {
 public:
  /// Starts at 2026-01-01T00:00:00Z on the wall.
  VirtualScheduler();

  SteadyTime now() const override { return now_; }
  WallTime wall_now() const override { return wall_; }
  void post(std::function<void()> call) override { posted_.push_back(std::move(call)); }
  Timer at(SteadyTime when, std::function<void()> call) override { return timers_.add(when, std::move(call)); }
  bool on_loop_thread() const override { return true; }

  /// Runs everything that is due now, posts included, until nothing is left.
  void run_ready();
  /// Moves time forward by `span`, running each timer at its own time.
  void run_for(Duration span);
  /// Time goes by and nothing runs, as while a process is stopped; what is due then runs late.
  void stop_for(Duration span) { advance_to(now_ + span); }
  /// `outside` is asked when nothing is left to do now, and waits a little for real parts: true if they posted
  /// something.
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
