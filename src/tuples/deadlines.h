#pragma once

#include <functional>
#include <vector>

#include "base/scheduler.h"
#include "tuples/store.h"

namespace rubicon::tuples {

/// A time at which a tuple expires (no subscription), or is due for a paced subscription.
struct Deadline {
  SteadyTime when{};
  std::uint64_t subscription = 0;
  std::uint32_t tuple = kNone;
  std::uint32_t generation = 0;
};

/// Deadlines on one timer, which is armed for the earliest. Those that were replaced stay until they are reached, or
/// until there are twice as many: the caller checks which still matter.
class Deadlines {
 public:
  using Call = std::function<void(const Deadline&, SteadyTime now)>;
  using StillMatters = std::function<bool(const Deadline&)>;

  Deadlines(Scheduler& scheduler, Call call, StillMatters still_matters);

  void add(const Deadline& deadline);
  std::size_t size() const { return heap_.size(); }

 private:
  void run();
  void arm();
  void sweep();

  Scheduler& scheduler_;
  Call call_;
  StillMatters still_matters_;
  std::vector<Deadline> heap_;
  std::size_t sweep_at_ = 1024;
  SteadyTime armed_ = SteadyTime::max();
  Timer timer_;
};

/// Longer lifetimes and intervals are cut to this, so that no sum of times overflows.
inline constexpr Duration kMaxDuration = std::chrono::hours(24 * 3650);

/// Expiry times of tuples on the steady clock of this process, because wall clocks may jump or differ.
class Expiry {
 public:
  Expiry(Deadlines& deadlines, Store& store) : deadlines_(deadlines), store_(store) {}

  /// Counts from `now`; no lifetime = never.
  void set(std::uint32_t index, Duration lifetime, SteadyTime now);
  void clear(std::uint32_t index) { times_.erase(index); }
  /// Whether this deadline of the tuple is the one that counts.
  bool is_armed(const Deadline& deadline) const;
  /// False if the tuple was set again meanwhile; then its new time is armed.
  bool is_due(std::uint32_t index, SteadyTime now);

 private:
  struct Times {
    SteadyTime ends{};
    SteadyTime armed = SteadyTime::max();
  };
  void arm(std::uint32_t index, Times& times);

  Deadlines& deadlines_;
  Store& store_;
  std::unordered_map<std::uint32_t, Times> times_;
};

/// Applies minimum interval, maximum interval and dead band of the subscriptions that have them.
class Pacer {
 public:
  enum class Due { kNothing, kChange, kHeartbeat };

  Pacer(Deadlines& deadlines, Store& store) : deadlines_(deadlines), store_(store) {}

  /// True: deliver the new value now. False: due() returns kChange later if it is to be delivered then.
  bool offer(Subscription& subscription, std::uint32_t index, SteadyTime now);
  /// An initial value was delivered.
  void begin(Subscription& subscription, std::uint32_t index, SteadyTime now);
  Due due(Subscription& subscription, std::uint32_t index, SteadyTime now);
  /// Whether this deadline of the subscription is the one that counts.
  static bool is_armed(const Subscription& subscription, const Deadline& deadline);

 private:
  bool within_dead_band(const Subscription& subscription, const Pace& pace, std::uint32_t index) const;
  void delivered(Subscription& subscription, Pace& pace, std::uint32_t index, SteadyTime now);
  void arm(const Subscription& subscription, Pace& pace, std::uint32_t index);

  Deadlines& deadlines_;
  Store& store_;
};

}  // namespace rubicon::tuples
