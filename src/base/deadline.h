#pragma once

#include <functional>
#include <utility>

#include "base/scheduler.h"

namespace rubicon::base {

/// A point in time that moves often and is seldom reached: moving it later costs no timer. Destroying it cancels the
/// call. One of these for the earliest of many times replaces a timer for each: advance_to() at each new one.
class Deadline {
 public:
  Deadline(Scheduler& scheduler, std::function<void()> call) : scheduler_(scheduler), call_(std::move(call)) {}
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  void set(Duration from_now) { set_at(scheduler_.now() + from_now); }
  void set_at(SteadyTime when) {
    due_ = when;
    if (when == SteadyTime::max() || (timer_.pending() && armed_for_ <= when)) return;
    arm();
  }
  /// Moves it only if `when` is earlier.
  void advance_to(SteadyTime when) {
    if (when < due_) set_at(when);
  }
  void clear() { due_ = SteadyTime::max(); }
  bool is_set() const { return due_ != SteadyTime::max(); }
  /// SteadyTime::max() = not set.
  SteadyTime due() const { return due_; }

 private:
  void arm() {
    armed_for_ = due_;
    timer_ = scheduler_.at(due_, [this] { reached(); });
  }
  void reached() {
    if (!is_set()) return;
    if (due_ > scheduler_.now()) return arm();
    clear();
    const auto call = call_;  // the call may destroy the owner of this
    call();
  }

  Scheduler& scheduler_;
  std::function<void()> call_;
  SteadyTime due_ = SteadyTime::max();
  SteadyTime armed_for_ = SteadyTime::max();
  Timer timer_;
};

}  // namespace rubicon::base
