#include "tuples/store.h"

namespace rubicon::tuples {

std::uint32_t Store::find(OwnerId owner, std::string_view key) const {
  return keys_.find(owner, key);
}

bool Store::is_present(TupleRef tuple) const {
  if (!pool_.contains(tuple.index)) return false;
  const auto& there = pool_[tuple.index];
  return there.present && there.generation == tuple.generation;
}

std::uint32_t Store::create(OwnerId owner, std::string_view key) {
  const auto node = tuples_.add(owner, key);
  const auto index = pool_.take(owner, key);
  tuples_.set_payload(node, index);
  keys_.add(index);
  auto& tuple = pool_[index];
  tuple.node = node;
  const auto set = subscribers_of(owner, node, key);
  tuple.subscribers = set;
  sets_.use(set);
  ++(owner == self_ ? own_ : cached_);
  return index;
}

std::uint32_t Store::subscribers_of(OwnerId owner, std::uint32_t node, std::string_view key) {
  matching_.clear();
  patterns_.matching(tuples_.path(node), matching_);
  std::vector<SubscriptionPtr> members;
  for (const auto pattern : matching_) {
    for (const auto& subscription : by_pattern_[pattern]) {
      if (!subscription->local() && owner != self_) continue;
      auto member = subscription->judged ? judged_(subscription, key) : subscription;
      if (member) members.push_back(std::move(member));
    }
  }
  if (members.size() > kFewSubscribers) return sets_.of(std::move(members));
  std::uint32_t set = 0;
  for (const auto& member : members) set = sets_.with(set, member);
  return set;
}

void Store::remove(std::uint32_t index, EventKind how) {
  auto& tuple = pool_[index];
  keys_.remove(index);
  tuples_.clear(tuple.node);
  for (auto* subscription : sets_[tuple.subscribers].paced) subscription->paces.erase(index);
  move_to(index, 0);
  --(tuple.owner == self_ ? own_ : cached_);
  pool_.end(index, how);
}

void Store::add(const SubscriptionPtr& subscription) {
  const auto node = patterns_.add(subscription->pattern.owner, subscription->pattern.key);
  auto list = patterns_.payload(node);
  if (list == kNone) {
    list = static_cast<std::uint32_t>(by_pattern_.size());
    if (free_patterns_.empty()) {
      by_pattern_.emplace_back();
    } else {
      list = free_patterns_.back();
      free_patterns_.pop_back();
    }
    patterns_.set_payload(node, list);
  }
  subscription->place = by_pattern_[list].size();
  by_pattern_[list].push_back(subscription);
}

void Store::drop(const SubscriptionPtr& subscription) {
  const auto node = patterns_.find(subscription->pattern.owner, subscription->pattern.key);
  if (node == kNone || patterns_.payload(node) == kNone) return;
  const auto list = patterns_.payload(node);
  auto& equals = by_pattern_[list];
  equals.back()->place = subscription->place;
  std::swap(equals[subscription->place], equals.back());
  equals.pop_back();
  if (!equals.empty()) return;
  free_patterns_.push_back(list);
  patterns_.clear(node);
}

bool Store::join(std::uint32_t index, const SubscriptionPtr& subscription) {
  return move_to(index, sets_.with(pool_[index].subscribers, subscription));
}

bool Store::leave(std::uint32_t index, const SubscriptionPtr& subscription) {
  return move_to(index, sets_.without(pool_[index].subscribers, subscription));
}

bool Store::move_to(std::uint32_t index, std::uint32_t set) {
  auto& tuple = pool_[index];
  if (tuple.subscribers == set) return false;
  sets_.use(set);
  sets_.release(tuple.subscribers);
  tuple.subscribers = set;
  return true;
}

TupleView Store::view(std::uint32_t index) const {
  const auto& t = pool_[index];
  return {t.owner,      t.key(),     t.value,      media_types_.name(t.media_type), t.creator, t.sequence,
          t.write_time, t.user_time, t.expire_time};
}

}  // namespace rubicon::tuples
