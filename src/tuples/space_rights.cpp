#include "tuples/peer_policy.h"

#include <algorithm>

#include "tuples/space_impl.h"

namespace rubicon::tuples {

namespace {

/// What a subscriber asked for, within its rights to demand.
Flow within(Flow flow, const Access& access) {
  flow.passive = flow.passive || !access.demand;
  if (!flow.passive) flow.minimum = std::max(flow.minimum, std::min(access.interval, kMaxDuration));
  return flow;
}

SubscriptionPtr held(const SubscriberSet& set, const SubscriptionPtr& subscription) {
  if (set.contains(*subscription)) return subscription;
  const auto& all = subscription->variants;
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& one) { return set.contains(*one); });
  return found == all.end() ? nullptr : *found;
}

}  // namespace

/// The subscription, or its variant with less demand; null if it may not read the tuple.
SubscriptionPtr TupleSpace::Impl::judged(const SubscriptionPtr& subscription, std::string_view key) {
  if (!subscription->judged) return subscription;
  const auto access = link.policy().access(subscription->peer->id, key);
  if (!access.read) return nullptr;
  const auto flow = within(subscription->flow, access);
  if (flow == subscription->flow) return subscription;
  for (const auto& variant : subscription->variants) {
    if (variant->flow != flow) continue;
    variant->used = true;
    return variant;
  }
  return add_variant(*subscription, flow);
}

SubscriptionPtr TupleSpace::Impl::add_variant(Subscription& subscription, const Flow& flow) {
  auto variant = std::make_shared<Subscription>();
  variant->number = ++last_number;
  variant->wire_id = subscription.wire_id;
  variant->pattern = subscription.pattern;
  variant->flow = flow;
  variant->peer = subscription.peer;
  variant->used = true;
  by_number.emplace(variant->number, variant);
  return subscription.variants.emplace_back(std::move(variant));
}

/// Gives a distant subscription what it may have of an own tuple now, and takes away what it had.
void TupleSpace::Impl::settle(const SubscriptionPtr& subscription, std::uint32_t index) {
  const auto wanted = judged(subscription, store.at(index).key());
  const auto current = held(store.subscribers(index), subscription);
  if (wanted == current) return;
  if (!wanted) return take_away(subscription, index);
  const auto demand_before = store.subscribers(index).demand;
  if (current) {
    store.leave(index, current);
    current->paces.erase(index);
  }
  store.join(index, wanted);
  demand.note(index, demand_before);
  if (wanted->paced()) pacer.begin(*wanted, index, now);
  deliver(wanted, index, EventKind::kSet);
}

/// From all subscriptions of that subscriber at once: the value of a later publication must not follow the end.
void TupleSpace::Impl::take_away(const SubscriptionPtr& subscription, std::uint32_t index) {
  const auto demand_before = store.subscribers(index).demand;
  auto members = store.subscribers(index).members;
  std::erase_if(members, [&](const auto& one) { return one->peer != subscription->peer; });
  for (const auto& one : members) {
    store.leave(index, one);
    one->paces.erase(index);
  }
  demand.note(index, demand_before);
  if (outbox.withdraw(*subscription->peer, index)) return;
  later([this, peer = subscription->peer->id] {
    open_turn();
    restart_stream(peer);
  });
}

/// A subscriber whose queue is full gets all that it may have from the beginning: the end of that snapshot takes away
/// the copies that it may not have.
void TupleSpace::Impl::restart_stream(OwnerId peer) {
  const auto found = subscribers.find(peer);
  if (found == subscribers.end() || !found->second.outgoing->broken) return;
  std::vector<SubscriptionSpec> specs;
  for (const auto& [id, one] : found->second.subscriptions) specs.push_back({id, one->pattern, one->flow});
  drop_peer(peer);
  for (const auto& spec : specs) on_subscribe(peer, spec);
}

void TupleSpace::Impl::rejudge() {
  open_turn();
  for (const auto& [id, peer] : subscribers) {
    const bool filters = link.policy().filters(id);
    for (const auto& one : peer.subscriptions) {
      const auto& subscription = one.second;
      if (!filters && !subscription->judged) continue;
      subscription->judged = filters;
      for (const auto& variant : subscription->variants) variant->used = false;
      ++subscription->rejudges;
      walk(Walk::Purpose::kRejudge, {self, subscription->pattern.key}, subscription);
    }
  }
}

/// The walk came to all tuples: what it did not find is a variant of former rights. While another walk is under way the
/// last one of them decides.
void TupleSpace::Impl::end_rejudge(Subscription& subscription) {
  if (--subscription.rejudges > 0) return;
  std::erase_if(subscription.variants, [this](const auto& variant) {
    if (variant->used) return false;
    variant->die();
    by_number.erase(variant->number);
    return true;
  });
}

void SpaceRights::limit_queues(TupleSpace& space, std::size_t most) {
  space.impl_->outbox.limit(most);
}

void SpaceRights::fetch(const TupleSpace& space, TupleRef tuple) {
  space.impl_->store.fetch(tuple);
}

bool SpaceRights::seeks(TupleSpace& space, std::optional<OwnerId> owner) {
  return space.impl_->link.seeks(owner);
}

void SpaceRights::rejudge(TupleSpace& space) {
  space.impl_->rejudge();
}

const Member* SpaceRights::asker(TupleSpace& space, const RemoteSet& set) {
  if (const auto* who = policy(space).asker(set)) return who;
  const auto* judge = SpaceRights::judge(space);
  return judge ? judge->spoken_for(set.from, set.request) : nullptr;
}

PeerPolicy& SpaceRights::policy(TupleSpace& space) {
  return space.impl_->link.policy();
}

}  // namespace rubicon::tuples
