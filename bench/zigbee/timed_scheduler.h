#pragma once

#include <algorithm>
#include <functional>
#include <utility>

#include "base/scheduler.h"
#include "frame/process_figures.h"

namespace rubicon::bench::zigbee {

/// Runs calls by another scheduler, which must outlive it, and notes how much processor time the longest took: what
/// other programs do meanwhile does not count.
class TimedScheduler final : public Scheduler {
 public:
  explicit TimedScheduler(Scheduler& scheduler) : scheduler_(scheduler) {}

  SteadyTime now() const override { return scheduler_.now(); }
  WallTime wall_now() const override { return scheduler_.wall_now(); }
  void post(std::function<void()> call) override { scheduler_.post(timed(std::move(call))); }
  Timer at(SteadyTime when, std::function<void()> call) override { return scheduler_.at(when, timed(std::move(call))); }
  bool on_loop_thread() const override { return scheduler_.on_loop_thread(); }

  /// Milliseconds, of all calls since the last forget().
  double longest_ms() const { return longest_ * 1e3; }
  void forget() { longest_ = 0; }
  void run(const std::function<void()>& call) {
    const auto start = thread_seconds();
    call();
    longest_ = std::max(longest_, thread_seconds() - start);
  }

 private:
  std::function<void()> timed(std::function<void()> call) {
    return [this, call = std::move(call)] { run(call); };
  }

  Scheduler& scheduler_;
  double longest_ = 0;  ///< seconds
};

}  // namespace rubicon::bench::zigbee
