#pragma once

#include <deque>
#include <unordered_map>
#include <vector>

#include "tuples/subscription.h"

namespace rubicon::tuples {

/// The demand for a tuple; members as in Demand.
struct DemandState {
  bool wanted = false;
  Duration interval{0};
  Duration named{0};
  friend bool operator==(const DemandState&, const DemandState&) = default;
};

/// The subscriptions that cover a tuple. Most tuples share one of few sets.
struct SubscriberSet {
  std::vector<SubscriptionPtr> members;  ///< sorted by number
  std::vector<Subscription*> plain;      ///< local, without pacing
  std::vector<Subscription*> paced;
  std::vector<PeerQueue*> peers;  ///< of the distant members without pacing, each once
  DemandState demand;
  std::uint64_t hash = 0;
  std::uint32_t uses = 0;  ///< by tuples and queued events

  bool contains(const Subscription& subscription) const;
};

/// Interned subscriber sets: a tuple refers to its set by number, so that adding a subscription to a million tuples
/// with the same set makes one new set. Set 0 is the empty one. collect() removes unused sets; no ids may be held
/// meanwhile.
class SubscriberSets {
 public:
  SubscriberSets() : sets_(1) { sets_[0].uses = 1; }

  const SubscriberSet& operator[](std::uint32_t id) const { return sets_[id]; }
  std::uint32_t with(std::uint32_t id, const SubscriptionPtr& subscription);
  std::uint32_t without(std::uint32_t id, const SubscriptionPtr& subscription);
  std::uint32_t of(std::vector<SubscriptionPtr> members);
  void use(std::uint32_t id) { ++sets_[id].uses; }
  void release(std::uint32_t id) { --sets_[id].uses; }
  void collect();
  std::size_t size() const { return sets_.size() - free_.size(); }

 private:
  struct Transition {
    std::uint64_t subscription;
    std::uint32_t from;
    bool adds;
    friend bool operator==(const Transition&, const Transition&) = default;
  };
  struct TransitionHash {
    std::size_t operator()(const Transition& t) const {
      return static_cast<std::size_t>((t.subscription * 2 + (t.adds ? 1 : 0)) * 0x9e3779b97f4a7c15u ^
                                      (std::uint64_t{t.from} * 0xc2b2ae3d27d4eb4fu));
    }
  };
  std::uint32_t intern(std::vector<SubscriptionPtr> members, std::uint64_t hash);
  static void fill(SubscriberSet& set);

  std::deque<SubscriberSet> sets_;
  std::vector<std::uint32_t> free_;
  std::unordered_multimap<std::uint64_t, std::uint32_t> by_hash_;
  std::unordered_map<Transition, std::uint32_t, TransitionHash> transitions_;
  std::size_t collect_at_ = 128;
};

}  // namespace rubicon::tuples
