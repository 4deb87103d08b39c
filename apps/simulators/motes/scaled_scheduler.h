#pragma once

#include "base/scheduler.h"

namespace rubicon::motes_simulator {

/// A clock that runs `speed` times as fast as that of another scheduler, which must outlive it.
class ScaledScheduler final : public Scheduler {
 public:
  ScaledScheduler(Scheduler& real, double speed)
      : real_(real), speed_(speed), began_(real.now()), wall_began_(real.wall_now()) {}

  SteadyTime now() const override { return began_ + scaled(real_.now() - began_, speed_); }
  WallTime wall_now() const override {
    return wall_began_ + std::chrono::duration_cast<WallTime::duration>(scaled(real_.now() - began_, speed_));
  }
  void post(std::function<void()> call) override { real_.post(std::move(call)); }
  Timer at(SteadyTime when, std::function<void()> call) override {
    return real_.at(began_ + scaled(when - began_, 1 / speed_), std::move(call));
  }
  bool on_loop_thread() const override { return real_.on_loop_thread(); }

 private:
  static SteadyTime::duration scaled(SteadyTime::duration span, double by) {
    return SteadyTime::duration(static_cast<SteadyTime::rep>(static_cast<double>(span.count()) * by));
  }

  Scheduler& real_;
  double speed_;
  SteadyTime began_;
  WallTime wall_began_;
};

}  // namespace rubicon::motes_simulator
