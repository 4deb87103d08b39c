#include "tuples/follower.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace rubicon::tuples {

Follower::Follower(TupleSpace& space, const Flow& flow, EventCall call, TargetCall target_call)
    : space_(space), flow_(flow), call_(std::move(call)), target_call_(std::move(target_call)) {}

void Follower::begin(const TupleName& meta) {
  chain_.push_back(meta);
  stops_.emplace_back();
  watch(0, Role::kReference);
}

void Follower::end() {
  ended_ = true;
  cut(0);
}

/// The new subscription begins before the old one of the same tuple ends: its copy stays.
void Follower::watch(std::size_t place, Role role) {
  auto& stop = stops_[place];
  if (stop.role == role) return;
  stop.role = role;
  const Flow passive{.passive = true};
  stop.subscription =
      space_.subscribe({chain_[place].owner, chain_[place].key}, role == Role::kTarget ? flow_ : passive,
                       [follower = weak_from_this(), place](const Event& event) {
                         if (const auto alive = follower.lock()) alive->on_event(place, event);
                       });
}

/// Forgets what comes behind `count` stops; their subscriptions end with the answer.
Follower::Stops Follower::cut(std::size_t count) {
  const auto first = stops_.begin() + static_cast<std::ptrdiff_t>(std::min(count, stops_.size()));
  Stops left(std::make_move_iterator(first), std::make_move_iterator(stops_.end()));
  stops_.erase(first, stops_.end());
  chain_.resize(stops_.size());
  return left;
}

void Follower::on_event(std::size_t place, const Event& event) {
  const bool set = event.kind == EventKind::kSet;
  if (stops_[place].role == Role::kTarget && !(set && is_reference(event.tuple.media_type))) return pass_on(event);
  if (!set) {
    // Should it be made again at once, the target's value is told again.
    const auto left = cut(place + 1);
    tell_gone(event.kind);
  }
  if (!ended_) follow(place);
}

/// What is left behind stays subscribed until all is told, so that its last value can be shown.
void Follower::follow(std::size_t at) {
  Stops left;
  auto next = next_reference(space_, std::span(chain_).first(at + 1));
  for (; next && *next; next = next_reference(space_, std::span(chain_).first(at + 1))) {
    watch(at, Role::kReference);
    if (++at < chain_.size() && chain_[at] == **next) continue;
    if (at < chain_.size()) left = cut(at);
    chain_.push_back(std::move(**next));
    stops_.emplace_back();
  }
  if (at + 1 < chain_.size()) left = cut(at + 1);
  watch(at, next ? Role::kTarget : Role::kReference);
  if (next) return tell_target(chain_.back());
  tell_gone(EventKind::kDeleted);
  if (!ended_) tell_target(fail(std::move(next.error())));
}

void Follower::pass_on(const Event& event) {
  if (event.kind == EventKind::kSet) {
    standing_ = chain_.back();
  } else if (!std::exchange(standing_, std::nullopt)) {
    return;
  }
  call_(event);
}

/// The view shows the last value if it can still be seen; copied, because the call may do anything.
void Follower::tell_gone(EventKind how) {
  const auto name = std::exchange(standing_, std::nullopt);
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

void Follower::tell_target(Result<TupleName> target) {
  const auto same = [&](const Result<TupleName>& told) {
    return told ? target && *told == *target : !target && told.error() == target.error();
  };
  if (target_ && same(*target_)) return;
  target_ = target;
  if (target_call_) target_call_(target);
}

}  // namespace rubicon::tuples
