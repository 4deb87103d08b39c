#include "tuples/follower.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace rubicon::tuples {

Follower::Follower(TupleSpace& space, const Flow& flow, EventCall call, TargetCall target_call)
    : space_(space), flow_(flow), call_(std::move(call)), target_call_(std::move(target_call)) {}

void Follower::begin(const TupleName& meta) {
  chain_.push_back(meta);
  hops_.emplace_back();
  watch(0, Role::kReference);
}

void Follower::end() {
  ended_ = true;
  cut(0);
}

/// The new subscription begins before the old one of the same tuple ends, so that the copy stays.
void Follower::watch(std::size_t position, Role role) {
  auto& hop = hops_[position];
  if (hop.role == role) return;
  hop.role = role;
  const Flow passive{.passive = true};
  hop.subscription =
      space_.subscribe({chain_[position].owner, chain_[position].key}, role == Role::kTarget ? flow_ : passive,
                       [follower = weak_from_this(), position](const Event& event) {
                         if (const auto alive = follower.lock()) alive->on_event(position, event);
                       });
}

/// Forgets what comes behind `count` stops; their subscriptions end with the answer.
Follower::Hops Follower::cut(std::size_t count) {
  const auto first = hops_.begin() + static_cast<std::ptrdiff_t>(std::min(count, hops_.size()));
  Hops left(std::make_move_iterator(first), std::make_move_iterator(hops_.end()));
  hops_.erase(first, hops_.end());
  chain_.resize(hops_.size());
  return left;
}

void Follower::on_event(std::size_t position, const Event& event) {
  const bool set = event.kind == EventKind::kSet;
  if (hops_[position].role == Role::kTarget && !(set && is_reference(event.tuple.media_type))) return forward(event);
  if (!set) {
    // If the tuple is created again at once, the target's value is delivered again.
    const auto left = cut(position + 1);
    report_removed(event.kind);
  }
  if (!ended_) follow(position);
}

/// Removed hops stay subscribed until everything is reported, so that the last value can be shown.
void Follower::follow(std::size_t at) {
  Hops left;
  auto next = next_reference(space_, std::span(chain_).first(at + 1));
  for (; next && *next; next = next_reference(space_, std::span(chain_).first(at + 1))) {
    watch(at, Role::kReference);
    if (++at < chain_.size() && chain_[at] == **next) continue;
    if (at < chain_.size()) left = cut(at);
    chain_.push_back(std::move(**next));
    hops_.emplace_back();
  }
  if (at + 1 < chain_.size()) left = cut(at + 1);
  watch(at, next ? Role::kTarget : Role::kReference);
  if (next) return report_target(chain_.back());
  report_removed(EventKind::kDeleted);
  if (!ended_) report_target(fail(std::move(next.error())));
}

void Follower::forward(const Event& event) {
  if (event.kind == EventKind::kSet) {
    delivered_ = chain_.back();
  } else if (!std::exchange(delivered_, std::nullopt)) {
    return;
  }
  call_(event);
}

/// The event shows the last value if it is still known; it is copied, because the call may change the space.
void Follower::report_removed(EventKind how) {
  const auto name = std::exchange(delivered_, std::nullopt);
  if (!name) return;
  Event event{how, {}};
  if (const auto last = space_.get(name->owner, name->key)) event.tuple = *last;
  const std::string value(event.tuple.value);
  const std::string media_type(event.tuple.media_type);
  event.tuple.owner = name->owner;
  event.tuple.key = name->key;
  event.tuple.value = value;
  event.tuple.media_type = media_type;
  call_(event);
}

void Follower::report_target(Result<TupleName> target) {
  const auto same = [&](const Result<TupleName>& reported) {
    return reported ? target && *reported == *target : !target && reported.error() == target.error();
  };
  if (target_ && same(*target_)) return;
  target_ = target;
  if (target_call_) target_call_(target);
}

}  // namespace rubicon::tuples
