#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/scheduler.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::transport {

/// Real time on an io_context, which must outlive it. Posted calls run in batches: what a batch posts runs in the next
/// one, so that timers and I/O are not starved. post() may be called from any thread, all else only from the loop's.
class AsioScheduler final : public base::Scheduler {
 public:
  explicit AsioScheduler(boost::asio::io_context& context);
  ~AsioScheduler() override;

  SteadyTime now() const override;
  WallTime wall_now() const override;
  void post(std::function<void()> call) override;
  Timer at(SteadyTime when, std::function<void()> call) override;
  bool on_loop_thread() const override;

  /// Makes the calling thread the loop's, which at first is the one that constructed the scheduler.
  void adopt_thread();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

/// The loop of a process: an io_context and the scheduler on it.
class Loop {
 public:
  Loop();
  ~Loop();

  AsioScheduler& scheduler();
  boost::asio::io_context& context();

  /// Runs until stop(), on this thread.
  void run();
  /// May be called from any thread.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Calls `call` on the loop's thread at each of these signals (SIGTERM, ...). Until this is destroyed the signals do
/// not end the process.
class Signals {
 public:
  Signals(Loop& loop, const std::vector<int>& numbers, std::function<void()> call);
  ~Signals();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace rubicon::transport
