#pragma once

#include <functional>
#include <memory>

#include "rubicon/time.hpp"

namespace rubicon::base {

/// A pending call; after destroying or cancelling it the call does not happen. May outlive its scheduler.
class Timer {
 public:
  struct Entry {
    std::function<void()> call;  ///< empty = cancelled or done
  };

  Timer() = default;
  explicit Timer(std::shared_ptr<Entry> entry) : entry_(std::move(entry)) {}
  Timer(Timer&&) noexcept = default;
  Timer& operator=(Timer&& other) noexcept;
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;
  ~Timer() { cancel(); }

  void cancel();
  bool pending() const { return entry_ && entry_->call; }

 private:
  std::shared_ptr<Entry> entry_;
};

/// The only source of time and of delayed calls; a constructor argument of everything that waits.
class Scheduler {
 public:
  virtual ~Scheduler() = default;

  virtual SteadyTime now() const = 0;
  virtual WallTime wall_now() const = 0;

  /// Calls `call` in a later turn of the loop, in the order of posting, never from inside post().
  virtual void post(std::function<void()> call) = 0;

  /// Calls `call` once, not before `when`; calls with equal times run in the order of at().
  [[nodiscard]] virtual Timer at(SteadyTime when, std::function<void()> call) = 0;
  [[nodiscard]] Timer after(Duration delay, std::function<void()> call) { return at(now() + delay, std::move(call)); }

  /// True on the thread that runs the loop; debug builds assert it at the entry points of the core.
  virtual bool on_loop_thread() const = 0;
};

}  // namespace rubicon::base

namespace rubicon {
using base::Scheduler;
using base::Timer;
}  // namespace rubicon
