#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/tuple.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::tuples {

/// Remote sets that wait a little until their owners are met: the engine looks for them, or has met only stand-ins so
/// far. Bounded.
class HeldSets {
 public:
  static constexpr std::size_t kMax = 1000, kMaxBytes = 4 * 1024 * 1024;

  struct Held {
    RemoteSet set;
    SteadyTime since{};
  };

  bool has(OwnerId owner) const { return held_.contains(owner); }
  /// False: too many, or too large.
  bool hold(const RemoteSet& set, SteadyTime now);
  /// The sets to this owner whose time to live has not ended, in their order.
  std::vector<RemoteSet> take(OwnerId owner, SteadyTime now);
  std::vector<OwnerId> owners() const;
  /// Sets whose time to live ended are answered already.
  void drop_ended(SteadyTime now);
  void clear();

 private:
  std::map<OwnerId, std::vector<Held>> held_;
  std::size_t count_ = 0, bytes_ = 0;
};

/// Own remote sets that wait for their replies. Each gets exactly one, at the latest 10 ms after its time to live
/// ended: one timer serves them all.
class Requests {
 public:
  static constexpr std::size_t kMax = 100'000;

  Requests(OwnerId self, Scheduler& scheduler);

  bool full() const { return open_.size() >= kMax; }
  std::uint64_t next_number() { return ++last_; }
  void open(std::uint64_t request, OwnerId owner, Duration time_to_live, ReplyCall call);
  /// The time that remains for a request; nullopt if it was answered.
  std::optional<Duration> remaining(std::uint64_t request) const;
  /// Whether it may have been executed: from the beginning on, unless it waits here.
  void set_left(std::uint64_t request, bool left);
  /// False: another component than the owner answers, which changes nothing: numbers are easy to guess.
  bool answer(OwnerId from, const Reply& reply);

 private:
  struct Open {
    OwnerId owner;
    ReplyCall call;
    SteadyTime ends;
    bool left = true;
  };
  void expire();

  OwnerId self_;
  Scheduler& scheduler_;
  std::unordered_map<std::uint64_t, Open> open_;
  std::uint64_t last_ = 0;
  base::Deadline next_{scheduler_, [this] { expire(); }};  ///< at or before the first end of those that are open
  base::Lifetime lifetime_;
};

/// The policies that decide about remote sets of own tuples.
class SetPolicies {
 public:
  struct PolicyEntry {
    Pattern pattern;
    SetPolicy policy;
    PolicyScope scope;
  };
  std::shared_ptr<PolicyEntry> add(const Pattern& pattern, SetPolicy policy, PolicyScope scope);
  void remove(const std::shared_ptr<PolicyEntry>& entry) { std::erase(entries_, entry); }
  /// The narrowest that matches; the earlier one of equally narrow ones. nullptr: none.
  std::shared_ptr<PolicyEntry> find(OwnerId self, std::string_view key) const;

 private:
  std::vector<std::shared_ptr<PolicyEntry>> entries_;  // narrowest first
};

}  // namespace rubicon::tuples
