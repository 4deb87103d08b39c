#pragma once

#include <functional>
#include <memory>

#include "base/scheduler.h"

namespace rubicon::transport {

/// The process's one loop: an io_context run by the thread that calls run(), as a Scheduler. Also where signals and
/// standard input enter.
class AsioLoop final : public Scheduler {
 public:
  AsioLoop();
  ~AsioLoop() override;

  SteadyTime now() const override;
  WallTime wall_now() const override;
  void post(std::function<void()> call) override;
  Timer at(SteadyTime when, std::function<void()> call) override;
  bool on_loop_thread() const override;

  /// Runs until stop(); what was posted before may be run first.
  void run();
  /// From the loop, or from a signal handler of on_signal().
  void stop();

  /// Calls on the loop when one of these signals arrives.
  void on_signals(std::initializer_list<int> signals, std::function<void(int)> call);

  struct Parts;
  /// For the other adapters of this folder.
  Parts& parts() { return *parts_; }

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace rubicon::transport
