#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "base/scheduler.h"

namespace rubicon::base {

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
