#include "tuples/subscriber_sets.h"

#include <algorithm>

namespace rubicon::tuples {

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

}  // namespace rubicon::tuples
