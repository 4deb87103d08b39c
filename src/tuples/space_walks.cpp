#include <algorithm>

#include "tuples/peer_policy.h"
#include "tuples/space_impl.h"

namespace rubicon::tuples {

namespace {

/// Walks pause while more events than this wait for local subscribers.
constexpr std::size_t kQueueForWalks = 100'000;

/// Changing a subscriber set copies it: this many members cost as much of the budget as one node.
constexpr std::size_t kMembersPerNode = 16;

Flow bounded(Flow flow) {
  flow.minimum = std::clamp(flow.minimum, Duration(0), kMaxDuration);
  flow.maximum = std::clamp(flow.maximum, Duration(0), kMaxDuration);
  return flow;
}

}  // namespace

bool is_sound(const Pattern& pattern) {
  return pattern.key.find(':') == pattern.key.npos && Pattern::parse(pattern.key).has_value();
}

SubscriptionPtr TupleSpace::Impl::subscribe(const Pattern& pattern, const Flow& flow, EventCall call,
                                            std::shared_ptr<PeerQueue> peer, std::uint32_t wire_id) {
  open_turn();
  auto subscription = std::make_shared<Subscription>();
  subscription->number = ++last_number;
  subscription->wire_id = wire_id;
  subscription->pattern = pattern;
  subscription->flow = bounded(flow);
  subscription->call = std::move(call);
  subscription->peer = std::move(peer);
  subscription->judged = !subscription->local() && link.policy().filters(subscription->peer->id);
  by_number.emplace(subscription->number, subscription);
  store.add(subscription);
  walk(Walk::Purpose::kJoin, pattern, subscription);
  return subscription;
}

void TupleSpace::Impl::unsubscribe(const SubscriptionPtr& subscription) {
  open_turn();
  subscription->die();
  by_number.erase(subscription->number);
  for (const auto& variant : subscription->variants) by_number.erase(variant->number);
  store.drop(subscription);
  walk(Walk::Purpose::kLeave, subscription->pattern, subscription);
}

std::uint32_t TupleSpace::Impl::free_wire_id() {
  do {
    ++last_wire_id;
  } while (last_wire_id == 0 || by_wire_id.contains(last_wire_id));
  return last_wire_id;
}

/// Completes a short walk at once, a long one in later turns.
void TupleSpace::Impl::walk(Walk::Purpose purpose, const Pattern& pattern, SubscriptionPtr subscription) {
  auto begun =
      std::make_unique<Walk>(purpose, store.trie(), pattern, std::move(subscription), store.pool().generation());
  if (resume(*begun)) return;
  erasing += purpose == Walk::Purpose::kErase;
  walks.push_back(std::move(begun));
}

/// True: the walk is complete.
bool TupleSpace::Impl::resume(Walk& walk) {
  const bool joins = walk.purpose == Walk::Purpose::kJoin || walk.purpose == Walk::Purpose::kRejudge;
  const bool over = joins && !walk.subscription->alive;
  while (!over) {
    if (queue.size() > kQueueForWalks) return false;
    const auto index = walk.steps.next(walk_budget);
    if (!index) break;
    walk_budget -= std::min(walk_budget, store.subscribers(*index).members.size() / kMembersPerNode);
    visit(walk, *index);
  }
  if (!over && !walk.steps.done()) return false;
  if (walk.purpose == Walk::Purpose::kRejudge && !over) end_rejudge(*walk.subscription);
  if (walk.purpose == Walk::Purpose::kJoin && !over && !walk.subscription->local()) {
    outbox.add(*walk.subscription->peer, SnapshotEnd{walk.subscription->wire_id});
  }
  return true;
}

void TupleSpace::Impl::run_walks() {
  while (!walks.empty() && walk_budget > 0 && resume(*walks.front())) {
    erasing -= walks.front()->purpose == Walk::Purpose::kErase;
    walks.pop_front();
  }
}

void TupleSpace::Impl::visit(Walk& walk, std::uint32_t index) {
  const auto& tuple = store.at(index);
  switch (walk.purpose) {
    case Walk::Purpose::kRejudge:
    case Walk::Purpose::kJoin: join(walk.subscription, index); break;
    case Walk::Purpose::kLeave: leave(walk.subscription, index); break;
    case Walk::Purpose::kErase:
      if (walk.is_older(tuple)) remove(index, EventKind::kDeleted);
      break;
    case Walk::Purpose::kReconcile:
      if (tuple.epoch != epochs[tuple.owner]) remove(index, EventKind::kDeleted);
      break;
    case Walk::Purpose::kForget:
      if (absent.contains(tuple.owner)) remove(index, EventKind::kLost);
      break;
  }
}

void TupleSpace::Impl::join(const SubscriptionPtr& subscription, std::uint32_t index) {
  const auto& tuple = store.at(index);
  const bool own = tuple.owner == self;
  if ((!own && !subscription->local()) || pending_erase(index)) return;
  if (!subscription->local()) return settle(subscription, index);
  const auto demand_before = store.subscribers(index).demand;
  if (!store.join(index, subscription)) return;
  if (own) demand.note(index, demand_before);
  if (subscription->paced()) pacer.begin(*subscription, index, now);
  deliver(subscription, index, EventKind::kSet);
}

/// A copy without subscribers is dropped without an event.
void TupleSpace::Impl::leave(const SubscriptionPtr& subscription, std::uint32_t index) {
  const auto demand_before = store.subscribers(index).demand;
  bool left = store.leave(index, subscription);
  for (const auto& variant : subscription->variants) left = store.leave(index, variant) || left;
  if (!left) return;
  if (store.at(index).owner == self) {
    demand.note(index, demand_before);
  } else if (store.at(index).subscribers == 0) {
    expiry.clear(index);
    store.remove(index, EventKind::kDeleted);
  }
}

}  // namespace rubicon::tuples
