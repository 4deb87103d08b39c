#pragma once

#include <memory>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "transport/descriptor_watch.h"

namespace rubicon::transport {

/// A loop for programs that have an event loop of their own: one file descriptor tells when there is work. One thread
/// at a time uses it: the one that called poll() or wait() last. post() may be called from any thread.
class PollLoop final : public base::Scheduler {
 public:
  /// kIo if the system has no descriptors left.
  static Result<std::unique_ptr<PollLoop>> make();
  ~PollLoop() override;

  /// Readable (epoll, poll, select) when poll() has work. Owned by the loop.
  int descriptor() const;
  /// Runs what is due, without waiting. Calls posted meanwhile run the next time. Must not be called by one of the
  /// calls that it makes.
  void poll();
  /// Waits until there is work, at most for the timeout.
  void wait(Duration timeout);
  /// Ends wait(). May be called from any thread and from signal handlers.
  void wake();

  /// Its calls come from poll(), before those of timers. The loop outlives the watch.
  std::unique_ptr<DescriptorWatch> watch(int descriptor, DescriptorCalls calls);

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
