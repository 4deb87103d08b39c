#pragma once

#include <functional>

#include "tuples/key_table.h"
#include "tuples/subscriber_sets.h"

namespace rubicon::tuples {

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
  std::size_t own_ = 0;
  std::size_t cached_ = 0;
};

}  // namespace rubicon::tuples
