#include <algorithm>

#include "tuples/space_impl.h"

namespace rubicon::tuples {

namespace {

/// Walks pause while more than this waits for local subscribers.
constexpr std::size_t kQueueForWalks = 100'000;

/// Changing a set copies it: so many members count as much as one node.
constexpr std::size_t kMembersPerNode = 16;

Flow bounded(Flow flow) {
  flow.minimum = std::clamp(flow.minimum, Duration(0), kLongest);
  flow.maximum = std::clamp(flow.maximum, Duration(0), kLongest);
  return flow;
}

}  // namespace

bool is_sound(const Pattern& pattern) {
  return pattern.key.find(':') == pattern.key.npos && Pattern::parse(pattern.key).has_value();
}

SubscriptionPtr TupleSpace::Impl::subscribe(const Pattern& pattern, const Flow& flow, EventCall call,
                                            std::shared_ptr<PeerBox> peer, std::uint32_t wire_id) {
  open_turn();
  auto subscription = std::make_shared<Subscription>();
  subscription->number = ++last_number;
  subscription->wire_id = wire_id;
  subscription->pattern = pattern;
  subscription->flow = bounded(flow);
  subscription->call = std::move(call);
  subscription->peer = std::move(peer);
  by_number.emplace(subscription->number, subscription);
  store.add(subscription);
  walk(Walk::Aim::kJoin, pattern, subscription);
  return subscription;
}

void TupleSpace::Impl::unsubscribe(const SubscriptionPtr& subscription) {
  open_turn();
  subscription->die();
  by_number.erase(subscription->number);
  store.drop(subscription);
  walk(Walk::Aim::kLeave, subscription->pattern, subscription);
}

std::uint32_t TupleSpace::Impl::free_wire_id() {
  do {
    ++last_wire_id;
  } while (last_wire_id == 0 || by_wire_id.contains(last_wire_id));
  return last_wire_id;
}

/// Small ones are done at once, the rest goes on in later turns.
void TupleSpace::Impl::walk(Walk::Aim aim, const Pattern& pattern, SubscriptionPtr subscription) {
  auto begun = std::make_unique<Walk>(aim, store.trie(), pattern, std::move(subscription), store.pool().generation());
  if (go_on(*begun)) return;
  erasing += aim == Walk::Aim::kErase;
  walks.push_back(std::move(begun));
}

bool TupleSpace::Impl::go_on(Walk& walk) {
  const bool over = walk.aim == Walk::Aim::kJoin && !walk.subscription->alive;
  while (!over) {
    if (queue.size() > kQueueForWalks) return false;
    const auto index = walk.steps.next(walk_budget);
    if (!index) break;
    walk_budget -= std::min(walk_budget, store.subscribers(*index).members.size() / kMembersPerNode);
    step(walk, *index);
  }
  if (!over && !walk.steps.done()) return false;
  if (walk.aim == Walk::Aim::kJoin && !over && !walk.subscription->local()) {
    outbox.mark_snapshot_end(*walk.subscription->peer, walk.subscription->wire_id);
  }
  return true;
}

void TupleSpace::Impl::run_walks() {
  while (!walks.empty() && walk_budget > 0 && go_on(*walks.front())) {
    erasing -= walks.front()->aim == Walk::Aim::kErase;
    walks.pop_front();
  }
}

void TupleSpace::Impl::step(Walk& walk, std::uint32_t index) {
  const auto& tuple = store.at(index);
  switch (walk.aim) {
    case Walk::Aim::kJoin: join(walk.subscription, index); break;
    case Walk::Aim::kLeave: leave(walk.subscription, index); break;
    case Walk::Aim::kErase:
      if (walk.is_older(tuple)) remove(index, EventKind::kDeleted);
      break;
    case Walk::Aim::kReconcile:
      if (tuple.epoch != epochs[tuple.owner]) remove(index, EventKind::kDeleted);
      break;
    case Walk::Aim::kForget:
      if (absent.contains(tuple.owner)) remove(index, EventKind::kLost);
      break;
  }
}

void TupleSpace::Impl::join(const SubscriptionPtr& subscription, std::uint32_t index) {
  const auto& tuple = store.at(index);
  const bool own = tuple.owner == self;
  if ((!own && !subscription->local()) || condemned(index)) return;
  const auto want = store.subscribers(index).want;
  if (!store.join(index, subscription)) return;
  if (own) demand.note(index, want);
  if (subscription->paced()) pacer.begin(*subscription, index, now);
  deliver(subscription, index, EventKind::kSet);
}

/// A copy that nobody here wants any more is dropped without an event.
void TupleSpace::Impl::leave(const SubscriptionPtr& subscription, std::uint32_t index) {
  const auto want = store.subscribers(index).want;
  if (!store.leave(index, subscription)) return;
  if (store.at(index).owner == self) {
    demand.note(index, want);
  } else if (store.at(index).subscribers == 0) {
    expiry.clear(index);
    store.remove(index, EventKind::kDeleted);
  }
}

}  // namespace rubicon::tuples
