#pragma once

#include <unordered_map>
#include <vector>

#include "tuples/store.h"

namespace rubicon::tuples {

/// Events for local subscribers, in the order of the sets. Beyond the limit a set of a tuple replaces an earlier one
/// that is also beyond the limit (merged); events beyond twice the limit are dropped and counted.
class EventQueue {
 public:
  static constexpr std::size_t kLimit = 1'000'000;
  /// Room for so many events is kept for later turns, and more as long as turns need an eighth of it.
  static constexpr std::size_t kKept = 4096;

  explicit EventQueue(Store& store, std::size_t limit = kLimit) : store_(store), limit_(limit) {}

  /// For the present local subscribers of the tuple without pacing.
  void push(std::uint32_t index, EventKind kind);
  /// For one subscription.
  void push_to(std::uint32_t index, EventKind kind, SubscriptionPtr target);
  /// Delivers the events that are queued now, at most `max`; the calls may change the space.
  void drain(std::size_t max);

  std::size_t size() const { return events_.size() - head_; }
  std::uint64_t delivered() const { return delivered_; }
  std::uint64_t merged() const { return merged_; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Queued {
    std::uint32_t tuple = 0;
    std::uint32_t set = 0;
    EventKind kind = EventKind::kSet;
    std::uint16_t media_type = 0;
    OwnerId creator{};
    std::uint64_t sequence = 0;
    WallTime write_time{};
    WallTime user_time{};
    WallTime expire_time{};
    StoredText value;
    SubscriptionPtr target;
  };
  Queued* room_for(std::uint32_t index, EventKind kind);
  void fill(Queued& queued, std::uint32_t index, EventKind kind, std::uint32_t set);
  void deliver(const Queued& queued);
  void call(Subscription& subscription, const Event& event);
  void shrink();

  Store& store_;
  std::size_t limit_;
  std::vector<Queued> events_;
  std::size_t head_ = 0;
  std::uint64_t taken_ = 0;  // events delivered since the start: head_ plus those erased
  std::unordered_map<std::uint32_t, std::uint64_t>
      beyond_;  // tuple -> its position beyond the limit, counted like taken_
  std::uint64_t delivered_ = 0;
  std::uint64_t merged_ = 0;
  std::uint64_t dropped_ = 0;
};

/// Reports changes of the demand for own tuples to watches, merged per turn.
class DemandWatches {
 public:
  struct Watch {
    Pattern pattern;
    DemandCall call;
    bool alive = true;
    bool is_new = true;  ///< the present demand has not been reported to it yet
  };

  DemandWatches(Store& store, OwnerId self) : store_(store), self_(self) {}

  std::shared_ptr<Watch> add(const Pattern& pattern, DemandCall call);
  void remove(const std::shared_ptr<Watch>& watch);

  /// The demand for an own tuple may have changed from `before`.
  void note(std::uint32_t index, const DemandState& before);
  bool pending() const { return !order_.empty() || any_new_; }
  void drain();

 private:
  void report_change(std::uint32_t index, const DemandState& before);
  void report_present(Watch& watch);
  void report(Watch& watch, std::uint32_t index, const DemandState& demand);
  DemandState demand_of(std::uint32_t index) const;

  Store& store_;
  OwnerId self_;
  std::vector<std::shared_ptr<Watch>> watches_;
  std::unordered_map<std::uint32_t, DemandState> before_;
  std::vector<std::uint32_t> order_;
  bool any_new_ = false;
};

}  // namespace rubicon::tuples
