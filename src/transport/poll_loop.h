#pragma once

#include <memory>

#include "base/scheduler.h"
#include "rubicon/result.hpp"

namespace rubicon::transport {

/// A loop for programs that have one of their own: everything waits behind one file descriptor. At any time one thread
/// uses it, whichever made the last call of poll() or wait(); post() may be called from all.
class PollLoop final : public base::Scheduler {
 public:
  /// kIo when the system gives no descriptors.
  static Result<std::unique_ptr<PollLoop>> make();
  ~PollLoop() override;

  /// Readable (epoll, poll, select) when poll() has something to do. Belongs to the loop.
  int descriptor() const;
  /// Does what is due, without waiting. What it posts waits for the next time. Never from one of the calls it makes.
  void poll();
  /// Waits until there is something to do, at most this long.
  void wait(Duration longest);
  /// Ends wait(). From any thread, and from signal handlers.
  void wake();

  SteadyTime now() const override;
  WallTime wall_now() const override;
  void post(std::function<void()> call) override;
  Timer at(SteadyTime when, std::function<void()> call) override;
  bool on_loop_thread() const override;

 private:
  struct Impl;
  explicit PollLoop(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::transport
