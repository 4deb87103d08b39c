#include "tuples/event_queue.h"

#include <algorithm>
#include <limits>

#include "base/prefetch.h"

namespace rubicon::tuples {

void EventQueue::push(std::uint32_t index, EventKind kind) {
  auto* queued = room_for(index, kind);
  if (!queued) return;
  fill(*queued, index, kind, store_.at(index).subscribers);
}

void EventQueue::push_to(std::uint32_t index, EventKind kind, SubscriptionPtr target) {
  if (size() >= 2 * limit_) {
    ++dropped_;
    return;
  }
  auto& queued = events_.emplace_back();
  store_.pool().pin(index);
  fill(queued, index, kind, 0);
  queued.target = std::move(target);
}

EventQueue::Queued* EventQueue::room_for(std::uint32_t index, EventKind kind) {
  if (size() >= limit_) {
    const auto waiting = beyond_.find(index);
    if (waiting != beyond_.end() && waiting->second >= taken_ && kind == EventKind::kSet) {
      ++merged_;
      auto& queued = events_[head_ + static_cast<std::size_t>(waiting->second - taken_)];
      store_.sets().release(queued.set);
      return &queued;
    }
    if (size() >= 2 * limit_) {
      ++dropped_;
      return nullptr;
    }
    beyond_[index] = taken_ + size();
  }
  store_.pool().pin(index);
  return &events_.emplace_back();
}

void EventQueue::fill(Queued& queued, std::uint32_t index, EventKind kind, std::uint32_t set) {
  const auto& tuple = store_.at(index);
  base::prefetch(tuple.key_text.get());  // needed at the end of the turn
  queued.tuple = index;
  queued.set = set;
  store_.sets().use(queued.set);
  queued.kind = kind;
  queued.media_type = tuple.media_type;
  queued.creator = tuple.creator;
  queued.sequence = tuple.sequence;
  queued.write_time = tuple.write_time;
  queued.user_time = tuple.user_time;
  queued.expire_time = store_.expire_time(index);
  queued.value = tuple.value;
}

void EventQueue::drain(std::size_t max) {
  for (auto count = std::min(size(), max); count > 0; --count) {
    // Moved out, because the calls may push.
    const Queued queued = std::move(events_[head_]);
    ++head_;
    ++taken_;
    deliver(queued);
    store_.sets().release(queued.set);
    store_.pool().unpin(queued.tuple);
  }
  shrink();
}

void EventQueue::deliver(const Queued& queued) {
  const auto& tuple = store_.at(queued.tuple);
  const Event event{queued.kind,
                    {tuple.owner, tuple.key(), queued.value, store_.media_types().name(queued.media_type),
                     queued.creator, queued.sequence, queued.write_time, queued.user_time, queued.expire_time}};
  if (queued.target) {
    call(*queued.target, event);
    return;
  }
  const auto& subscribers = store_.sets()[queued.set].plain;
  for (auto* subscription : subscribers) call(*subscription, event);
}

void EventQueue::call(Subscription& subscription, const Event& event) {
  if (!subscription.alive) return;
  ++delivered_;
  subscription.running = true;
  subscription.call(event);
  subscription.running = false;
  if (!subscription.alive) subscription.call = nullptr;
}

void EventQueue::shrink() {
  if (size() < limit_) beyond_.clear();
  if (head_ == events_.size()) {
    const bool needs_less = events_.capacity() > kKept && events_.size() < events_.capacity() / 8;
    events_.clear();
    head_ = 0;
    if (needs_less) events_.shrink_to_fit();
  } else if (head_ > 4096 && head_ > events_.size() / 2) {
    events_.erase(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(head_));
    head_ = 0;
  }
}

std::shared_ptr<DemandWatches::Watch> DemandWatches::add(const Pattern& pattern, DemandCall call) {
  any_new_ = true;
  return watches_.emplace_back(std::make_shared<Watch>(Watch{pattern, std::move(call)}));
}

void DemandWatches::remove(const std::shared_ptr<Watch>& watch) {
  watch->alive = false;
  std::erase(watches_, watch);
}

DemandState DemandWatches::demand_of(std::uint32_t index) const {
  return store_.at(index).present ? store_.subscribers(index).demand : DemandState{};
}

void DemandWatches::note(std::uint32_t index, const DemandState& before) {
  if (watches_.empty() || demand_of(index) == before) return;
  if (!before_.emplace(index, before).second) return;
  order_.push_back(index);
  store_.pool().pin(index);
}

void DemandWatches::drain() {
  const auto before = std::exchange(before_, {});
  for (const auto index : std::exchange(order_, {})) {
    report_change(index, before.at(index));
    store_.pool().unpin(index);
  }
  if (!std::exchange(any_new_, false)) return;
  for (const auto& watch : std::vector(watches_)) {
    if (watch->alive && std::exchange(watch->is_new, false)) report_present(*watch);
  }
}

void DemandWatches::report_change(std::uint32_t index, const DemandState& before) {
  const auto now = demand_of(index);
  if (now == before) return;
  for (const auto& watch : std::vector(watches_)) {
    if (watch->alive && !watch->is_new && watch->pattern.matches(self_, store_.at(index).key()))
      report(*watch, index, now);
  }
}

void DemandWatches::report_present(Watch& watch) {
  auto pattern = watch.pattern;
  if (pattern.owner && *pattern.owner != self_) return;
  pattern.owner = self_;
  PatternWalk walk(store_.trie(), pattern);
  auto budget = std::numeric_limits<std::size_t>::max();
  while (const auto index = walk.next(budget)) {
    if (!watch.alive) return;
    const auto demand = demand_of(*index);
    if (demand.wanted) report(watch, *index, demand);
  }
}

void DemandWatches::report(Watch& watch, std::uint32_t index, const DemandState& demand) {
  const auto& tuple = store_.at(index);
  store_.pool().pin(index);
  watch.call(Demand{{index, tuple.generation}, tuple.key(), demand.wanted, demand.interval, demand.named});
  store_.pool().unpin(index);
}

}  // namespace rubicon::tuples
