#include "tuples/store.h"

#include <algorithm>
#include <cstring>
#include <functional>

#include "base/assert.h"
#include "base/prefetch.h"

namespace rubicon::tuples {

static_assert(model::kMaxKeyLength <= 255, "Tuple::key_size is one byte");

std::uint16_t MediaTypes::intern(std::string_view name) {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found != names_.end()) return static_cast<std::uint16_t>(found - names_.begin());
  if (names_.size() >= kMaxTypes || name.size() > kMaxLength) return 0;
  names_.emplace_back(name);
  return static_cast<std::uint16_t>(names_.size() - 1);
}

std::uint32_t TuplePool::take(OwnerId owner, std::string_view key) {
  const auto index = free_.empty() ? tuples_.add() : free_.back();
  if (!free_.empty()) free_.pop_back();
  auto& tuple = (*this)[index];
  tuple.key_text = std::make_unique_for_overwrite<char[]>(key.size());
  std::memcpy(tuple.key_text.get(), key.data(), key.size());
  tuple.key_size = static_cast<std::uint8_t>(key.size());
  tuple.owner = owner;
  tuple.generation = ++generation_;
  tuple.present = true;
  return index;
}

void TuplePool::end(std::uint32_t index, EventKind how) {
  auto& tuple = (*this)[index];
  tuple.present = false;
  tuple.end = how;
  if (tuple.pins == 0) release(index);
}

void TuplePool::unpin(std::uint32_t index) {
  auto& tuple = (*this)[index];
  RUBICON_DEBUG_ASSERT(tuple.pins > 0);
  if (--tuple.pins == 0 && !tuple.present) release(index);
}

void TuplePool::release(std::uint32_t index) {
  auto& tuple = (*this)[index];
  const auto generation = tuple.generation;
  tuple = Tuple{};
  tuple.generation = generation;
  free_.push_back(index);
}

namespace {

std::uint32_t hash_of_key(OwnerId owner, std::string_view key) {
  const auto mixed = std::uint64_t{std::hash<std::string_view>()(key)} + number(owner) * 0x9e3779b97f4a7c15u;
  return static_cast<std::uint32_t>(mixed >> 32);
}

}  // namespace

std::uint32_t KeyTable::find(OwnerId owner, std::string_view key) const {
  return index_.find(hash_of_key(owner, key), [&](std::uint32_t index) {
    const auto& tuple = pool_[index];
    return tuple.owner == owner && tuple.key() == key;
  });
}

void KeyTable::add(std::uint32_t index) {
  const auto& tuple = pool_[index];
  index_.add(hash_of_key(tuple.owner, tuple.key()), index);
}

void KeyTable::remove(std::uint32_t index) {
  const auto& tuple = pool_[index];
  index_.remove(hash_of_key(tuple.owner, tuple.key()), index);
}

namespace {

bool before(const SubscriptionPtr& member, std::uint64_t number) {
  return member->number < number;
}

/// Order does not matter: a set's hash is the sum of its members'.
std::uint64_t hash_of(const Subscription& member) {
  std::uint64_t mixed = member.number * 0x9e3779b97f4a7c15u;
  mixed = (mixed ^ (mixed >> 29)) * 0xbf58476d1ce4e5b9u;
  return mixed ^ (mixed >> 32);
}

}  // namespace

bool SubscriberSet::contains(const Subscription& subscription) const {
  const auto at = std::lower_bound(members.begin(), members.end(), subscription.number, before);
  return at != members.end() && at->get() == &subscription;
}

std::uint32_t SubscriberSets::with(std::uint32_t id, const SubscriptionPtr& subscription) {
  const Transition step{subscription->number, id, true};
  if (const auto known = transitions_.find(step); known != transitions_.end()) return known->second;
  if (sets_[id].contains(*subscription)) return id;
  auto members = sets_[id].members;
  members.insert(std::lower_bound(members.begin(), members.end(), subscription->number, before), subscription);
  const auto made = intern(std::move(members), sets_[id].hash + hash_of(*subscription));
  transitions_.emplace(step, made);
  return made;
}

std::uint32_t SubscriberSets::without(std::uint32_t id, const SubscriptionPtr& subscription) {
  const Transition step{subscription->number, id, false};
  if (const auto known = transitions_.find(step); known != transitions_.end()) return known->second;
  if (!sets_[id].contains(*subscription)) return id;
  auto members = sets_[id].members;
  members.erase(std::lower_bound(members.begin(), members.end(), subscription->number, before));
  const auto made = intern(std::move(members), sets_[id].hash - hash_of(*subscription));
  transitions_.emplace(step, made);
  return made;
}

std::uint32_t SubscriberSets::of(std::vector<SubscriptionPtr> members) {
  std::sort(members.begin(), members.end(), [](const auto& a, const auto& b) { return a->number < b->number; });
  std::uint64_t hash = 0;
  for (const auto& member : members) hash += hash_of(*member);
  return intern(std::move(members), hash);
}

std::uint32_t SubscriberSets::intern(std::vector<SubscriptionPtr> members, std::uint64_t hash) {
  if (members.empty()) return 0;
  const auto [begin, end] = by_hash_.equal_range(hash);
  for (auto at = begin; at != end; ++at) {
    if (sets_[at->second].members == members) return at->second;
  }
  std::uint32_t id = static_cast<std::uint32_t>(sets_.size());
  if (free_.empty()) {
    sets_.emplace_back();
  } else {
    id = free_.back();
    free_.pop_back();
  }
  auto& set = sets_[id];
  set.members = std::move(members);
  set.hash = hash;
  fill(set);
  by_hash_.emplace(hash, id);
  return id;
}

void SubscriberSets::fill(SubscriberSet& set) {
  set.demand.interval = Duration::max();
  for (const auto& member : set.members) {
    if (member->paced()) {
      set.paced.push_back(member.get());
    } else if (member->local()) {
      set.plain.push_back(member.get());
    } else if (std::find(set.peers.begin(), set.peers.end(), member->peer.get()) == set.peers.end()) {
      set.peers.push_back(member->peer.get());
    }
    if (member->flow.passive) continue;
    set.demand.wanted = true;
    const auto minimum = member->flow.minimum;
    set.demand.interval = std::min(set.demand.interval, minimum);
    const bool shorter = set.demand.named == Duration(0) || minimum < set.demand.named;
    if (minimum != Duration(0) && shorter) set.demand.named = minimum;
  }
  if (!set.demand.wanted) set.demand.interval = Duration(0);
}

void SubscriberSets::collect() {
  if (size() < collect_at_) return;
  std::erase_if(transitions_,
                [&](const auto& entry) { return sets_[entry.first.from].uses == 0 || sets_[entry.second].uses == 0; });
  std::erase_if(by_hash_, [&](const auto& entry) {
    if (sets_[entry.second].uses > 0) return false;
    sets_[entry.second] = {};
    free_.push_back(entry.second);
    return true;
  });
  collect_at_ = std::max<std::size_t>(128, size() * 2);
}

std::uint32_t Store::find(OwnerId owner, std::string_view key) const {
  return keys_.find(owner, key);
}

bool Store::is_present(TupleRef tuple) const {
  if (!pool_.contains(tuple.index)) return false;
  const auto& there = pool_[tuple.index];
  return there.present && there.generation == tuple.generation;
}

void Store::fetch(TupleRef tuple) const {
  if (!pool_.contains(tuple.index)) return;
  const auto* begin = reinterpret_cast<const char*>(&pool_[tuple.index]);
  base::prefetch(begin);
  base::prefetch(begin + 64);
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
  set_expire_time(index, {});
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
  std::exchange(equals, {});  // one pattern may have had many subscriptions
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
  return {t.owner,      t.key(),     t.value,           media_types_.name(t.media_type), t.creator, t.sequence,
          t.write_time, t.user_time, expire_time(index)};
}

WallTime Store::expire_time(std::uint32_t index) const {
  return pool_[index].expires ? expire_times_.at(index) : WallTime{};
}

void Store::set_expire_time(std::uint32_t index, WallTime when) {
  auto& tuple = pool_[index];
  if (when != WallTime{}) {
    expire_times_[index] = when;
  } else if (tuple.expires) {
    expire_times_.erase(index);
  }
  tuple.expires = when != WallTime{};
}

}  // namespace rubicon::tuples
