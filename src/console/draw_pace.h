#pragma once

#include <functional>

#include "base/scheduler.h"

namespace rubicon::console {

/// When a screen is drawn: soon after it was asked for and else from time to time, but never so often that drawing
/// takes more than its share of the loop's time, however fast keys come.
class DrawPace {
 public:
  static constexpr Duration kIdle = std::chrono::milliseconds(500);
  /// Drawing takes at most one part in so many of the loop's time.
  static constexpr int kShare = 10;

  /// `draw` returns how long it took.
  DrawPace(Scheduler& scheduler, std::function<Duration()> draw) : scheduler_(scheduler), draw_(std::move(draw)) {}

  /// Draws once, in a later turn, for all who ask until then.
  void ask();

 private:
  void draw();

  Scheduler& scheduler_;
  std::function<Duration()> draw_;
  SteadyTime earliest_{};
  bool asked_ = false;
  Timer due_;
};

}  // namespace rubicon::console
