#pragma once

#include <cstdint>
#include <functional>

#include "base/scheduler.h"
#include "frame/figures.h"

namespace rubicon::bench::web {

/// Calls with the numbers 1, 2, 3 ... at an even pace, which may change.
class PacedUpdates {
 public:
  PacedUpdates(Scheduler& scheduler, std::function<void(std::uint64_t update)> call)
      : scheduler_(scheduler), call_(std::move(call)) {}

  /// Updates a second; 0 = none.
  void set_rate(int rate);
  std::uint64_t made() const { return made_; }

 private:
  void tick();

  Scheduler& scheduler_;
  std::function<void(std::uint64_t)> call_;
  int rate_ = 0;
  std::uint64_t made_ = 0, made_before_ = 0;  ///< before the present pace
  Clock::time_point began_;
  Timer next_;
};

}  // namespace rubicon::bench::web
