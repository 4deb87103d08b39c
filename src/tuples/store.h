#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/hash_index.h"
#include "rubicon/tuple_space.hpp"
#include "tuples/part_trie.h"
#include "tuples/stored_text.h"

namespace rubicon::tuples {

/// Interned media types. Bounded, because peers send them: beyond the limit a type becomes
/// `application/octet-stream`.
class MediaTypes {
 public:
  static constexpr std::size_t kMaxTypes = 4096;
  static constexpr std::size_t kMaxLength = 254;

  MediaTypes() : names_{"application/octet-stream", "text/plain", "application/json"} {}

  std::uint16_t intern(std::string_view name);
  std::string_view name(std::uint16_t id) const { return names_[id]; }

 private:
  std::deque<std::string> names_;  // views into them stay valid
};

/// One tuple in the store. A deleted one stays in memory while events about it are queued (pins). Its size and place
/// are such that it lies in two cache lines: tuples are visited in random order.
struct alignas(16) Tuple {
  std::unique_ptr<char[]> key_text;
  StoredText value;
  std::uint64_t sequence = 0;
  WallTime write_time{};
  WallTime user_time{};
  OwnerId owner{};
  OwnerId creator{};
  std::uint32_t generation = 0;  ///< differs from all earlier tuples with this index
  std::uint32_t node = kNone;
  std::uint32_t subscribers = 0;  ///< id of an interned set
  std::uint16_t media_type = 0;
  std::uint16_t epoch = 0;  ///< of a copy: the owner's epoch in which it was last confirmed
  std::uint32_t pins : 28 = 0;
  std::uint32_t present : 1 = 0;
  std::uint32_t expires : 1 = 0;            ///< Store::expire_time() says when
  EventKind end : 2 = EventKind::kDeleted;  ///< how it ended, if not present
  std::uint8_t key_size = 0;

  std::string_view key() const { return {key_text.get(), key_size}; }
};
static_assert(sizeof(Tuple) == 80);

/// Tuples by index; they never move.
class TuplePool {
 public:
  Tuple& operator[](std::uint32_t index) { return tuples_[index]; }
  const Tuple& operator[](std::uint32_t index) const { return tuples_[index]; }
  bool contains(std::uint32_t index) const { return index < tuples_.size(); }

  std::uint32_t take(OwnerId owner, std::string_view key);
  /// Marks the tuple as gone; its memory is reused after the last unpin().
  void end(std::uint32_t index, EventKind how);
  void pin(std::uint32_t index) { ++(*this)[index].pins; }
  void unpin(std::uint32_t index);

  std::uint32_t generation() const { return generation_; }

 private:
  void release(std::uint32_t index);

  Pages<Tuple> tuples_;
  std::vector<std::uint32_t> free_;
  std::uint32_t generation_ = 0;
};

/// Owner and key -> index of the tuple. The keys stay in the pool, which outlives it.
class KeyTable {
 public:
  explicit KeyTable(const TuplePool& pool) : pool_(pool) {}

  /// kNone: no such tuple.
  std::uint32_t find(OwnerId owner, std::string_view key) const;
  /// No tuple of that owner and key may be there yet.
  void add(std::uint32_t index);
  /// To be called while the pool has the tuple.
  void remove(std::uint32_t index);

 private:
  const TuplePool& pool_;
  base::HashIndex index_;
};

struct PeerQueue;

/// State of one paced subscription for one tuple.
struct Pace {
  SteadyTime last{};                     ///< of the last delivery
  SteadyTime armed = SteadyTime::max();  ///< earliest pending deadline
  double number = 0;                     ///< last delivered value
  bool has_number = false;
  bool pending = false;  ///< a value waits for the end of the minimum interval
};

/// One subscription, of this component or of a distant one; shared by all subscriber sets that contain it. No call is
/// made after die().
struct Subscription {
  std::uint64_t number = 0;  ///< unique in this space
  std::uint32_t wire_id = 0;
  Pattern pattern;
  Flow flow;
  EventCall call;
  std::function<void(OwnerId)> snapshot;  ///< local only: called when all tuples of an owner have arrived
  std::shared_ptr<PeerQueue> peer;        ///< queue of a distant subscriber; null = local
  std::size_t place = 0;                  ///< position among the subscriptions with the same pattern
  bool judged = false;                    ///< of a distant subscriber whose rights differ between tuples
  /// The same subscription with less demand, for the tuples where the subscriber has no right to more.
  std::vector<std::shared_ptr<Subscription>> variants;
  bool used = false;           ///< of a variant: a tuple got it since the last kRejudge walk began
  std::uint32_t rejudges = 0;  ///< kRejudge walks that are under way
  bool alive = true;
  bool running = false;  ///< inside its call
  std::unordered_map<std::uint32_t, Pace> paces;

  bool local() const { return peer == nullptr; }
  /// The receiver makes heartbeats: the maximum interval of a distant subscriber does not count here.
  bool paced() const {
    return flow.minimum > Duration(0) || flow.dead_band > 0 || (local() && flow.maximum > Duration(0));
  }
  void die() {
    alive = false;
    if (!running) call = nullptr;
    std::exchange(paces, {});
    for (const auto& variant : variants) variant->die();
  }
};
using SubscriptionPtr = std::shared_ptr<Subscription>;

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

/// Own and cached tuples and the subscriptions that cover them, without time, queues or links: the index of
/// docs/decisions/003. Setting a tuple touches neither other tuples nor patterns.
class Store {
 public:
  explicit Store(OwnerId self) : self_(self), tuples_(names_), patterns_(names_), keys_(pool_) {}

  std::uint32_t find(OwnerId owner, std::string_view key) const;
  /// Creates a tuple with its subscribers and an empty value. The key must be valid and unused.
  std::uint32_t create(OwnerId owner, std::string_view key);
  /// Its index stays valid while pinned.
  void remove(std::uint32_t index, EventKind how);

  Tuple& at(std::uint32_t index) { return pool_[index]; }
  const Tuple& at(std::uint32_t index) const { return pool_[index]; }
  const SubscriberSet& subscribers(std::uint32_t index) const { return sets_[pool_[index].subscribers]; }
  bool is_present(TupleRef tuple) const;
  void fetch(TupleRef tuple) const;

  /// What a distant subscription with rights of its own gets of an own tuple; null = nothing.
  using Judged = std::function<SubscriptionPtr(const SubscriptionPtr&, std::string_view key)>;
  void judge_by(Judged judged) { judged_ = std::move(judged); }

  /// Adds the subscription to future tuples; present ones are joined one by one.
  void add(const SubscriptionPtr& subscription);
  void drop(const SubscriptionPtr& subscription);
  /// False if nothing changed.
  bool join(std::uint32_t index, const SubscriptionPtr& subscription);
  bool leave(std::uint32_t index, const SubscriptionPtr& subscription);

  TuplePool& pool() { return pool_; }
  PartTrie& trie() { return tuples_; }
  SubscriberSets& sets() { return sets_; }
  MediaTypes& media_types() { return media_types_; }
  const MediaTypes& media_types() const { return media_types_; }
  TupleView view(std::uint32_t index) const;
  /// Few tuples expire. WallTime{} = never.
  WallTime expire_time(std::uint32_t index) const;
  void set_expire_time(std::uint32_t index, WallTime when);
  /// Later values seldom equal those of other tuples: only the first one looks for a text to share.
  void set_value(Tuple& tuple, std::string_view value) {
    tuple.sequence == 0 ? shared_texts_.assign(tuple.value, value) : tuple.value.assign(value);
  }
  std::size_t own() const { return own_; }
  std::size_t cached() const { return cached_; }

 private:
  /// Up to this many subscribers are added one by one, along cached transitions.
  static constexpr std::size_t kFewSubscribers = 8;

  std::uint32_t subscribers_of(OwnerId owner, std::uint32_t node, std::string_view key);
  bool move_to(std::uint32_t index, std::uint32_t set);

  OwnerId self_;
  Judged judged_;
  PartNames names_;
  PartTrie tuples_;
  PartTrie patterns_;
  std::vector<std::vector<SubscriptionPtr>> by_pattern_;  // payloads of patterns_
  std::vector<std::uint32_t> free_patterns_;
  std::vector<std::uint32_t> matching_;
  TuplePool pool_;
  KeyTable keys_;
  SubscriberSets sets_;
  MediaTypes media_types_;
  SharedTexts shared_texts_;
  std::unordered_map<std::uint32_t, WallTime> expire_times_;
  std::size_t own_ = 0;
  std::size_t cached_ = 0;
};

}  // namespace rubicon::tuples
