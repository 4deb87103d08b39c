#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

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

namespace rubicon::base {

/// A point in time that moves often and is seldom reached: moving it later costs no timer. Destroying it cancels the
/// call. One of these for the earliest of many times replaces a timer for each: advance_to() at each new one.
class Deadline {
 public:
  Deadline(Scheduler& scheduler, std::function<void()> call) : scheduler_(scheduler), call_(std::move(call)) {}
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  void set(Duration from_now) { set_at(scheduler_.now() + from_now); }
  void set_at(SteadyTime when) {
    due_ = when;
    if (when == SteadyTime::max() || (timer_.pending() && armed_for_ <= when)) return;
    arm();
  }
  /// Moves it only if `when` is earlier.
  void advance_to(SteadyTime when) {
    if (when < due_) set_at(when);
  }
  void clear() { due_ = SteadyTime::max(); }
  bool is_set() const { return due_ != SteadyTime::max(); }
  /// SteadyTime::max() = not set.
  SteadyTime due() const { return due_; }

 private:
  void arm() {
    armed_for_ = due_;
    timer_ = scheduler_.at(due_, [this] { reached(); });
  }
  void reached() {
    if (!is_set()) return;
    if (due_ > scheduler_.now()) return arm();
    clear();
    const auto call = call_;  // the call may destroy the owner of this
    call();
  }

  Scheduler& scheduler_;
  std::function<void()> call_;
  SteadyTime due_ = SteadyTime::max();
  SteadyTime armed_for_ = SteadyTime::max();
  Timer timer_;
};

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

/// A member of an object whose calls must not happen once the object is destroyed. Declare it last: it then ends first.
class Lifetime {
 public:
  /// Answers after the owner may have been destroyed. Cheap to copy, may outlive the owner.
  class Watch {
   public:
    explicit Watch(std::weak_ptr<const bool> owner) : owner_(std::move(owner)) {}
    bool ended() const { return owner_.expired(); }

   private:
    std::weak_ptr<const bool> owner_;
  };

  Lifetime() = default;
  Lifetime(const Lifetime&) = delete;
  Lifetime& operator=(const Lifetime&) = delete;

  Watch watch() const { return Watch(owner_); }

  /// `call`, but nothing happens once the owner is destroyed. For callbacks that others keep; `call` returns nothing.
  template <class Call>
  auto guard(Call call) const {
    return [watch = watch(), call = std::move(call)](auto&&... arguments) mutable {
      if (!watch.ended()) call(std::forward<decltype(arguments)>(arguments)...);
    };
  }

  /// Calls `call` in a later turn, unless the owner is destroyed by then.
  template <class Call>
  void post(Scheduler& scheduler, Call call) const {
    scheduler.post(guard(std::move(call)));
  }

  /// Ends it before the owner is destroyed.
  void end() { owner_.reset(); }

 private:
  std::shared_ptr<const bool> owner_ = std::make_shared<const bool>(true);
};

/// Posts a call at most once until it ran: many requests of one turn become one call in a later turn. Destroying it
/// cancels the call. The call may destroy this.
class OncePerTurn {
 public:
  OncePerTurn(Scheduler& scheduler, std::function<void()> call)
      : scheduler_(scheduler), state_(std::make_shared<State>(State{std::move(call), false})) {}

  void request() {
    if (std::exchange(state_->requested, true)) return;
    scheduler_.post([state = std::weak_ptr(state_)] {
      const auto alive = state.lock();
      if (!alive) return;
      alive->requested = false;
      alive->call();
    });
  }

 private:
  struct State {
    std::function<void()> call;
    bool requested;
  };

  Scheduler& scheduler_;
  std::shared_ptr<State> state_;
};

}  // namespace rubicon::base
