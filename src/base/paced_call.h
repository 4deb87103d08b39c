#pragma once

#include <algorithm>
#include <functional>
#include <utility>

#include "base/scheduler.h"

namespace rubicon::base {

/// Calls at most once per pause, however often it is requested: at once (in a later turn) if the last call is longer
/// ago, else at the end of the pause. Destroying it cancels the call.
class PacedCall {
 public:
  PacedCall(Scheduler& scheduler, Duration pause, std::function<void()> call)
      : scheduler_(scheduler), pause_(pause), call_(std::move(call)) {}
  PacedCall(const PacedCall&) = delete;
  PacedCall& operator=(const PacedCall&) = delete;

  /// Calls now, in place of a requested call, and starts the pause.
  void call_now() {
    timer_.cancel();
    run();
  }

  void request() {
    if (timer_.pending()) return;
    timer_ = scheduler_.at(std::max(not_before_, scheduler_.now()), [this] { run(); });
  }

 private:
  void run() {
    not_before_ = scheduler_.now() + pause_;
    const auto call = call_;  // the call may destroy the owner of this
    call();
  }

  Scheduler& scheduler_;
  Duration pause_;
  std::function<void()> call_;
  Timer timer_;
  SteadyTime not_before_{};
};

}  // namespace rubicon::base
