#include <fmt/format.h>

#include <algorithm>

#include "base/assert.h"
#include "tuples/space_impl.h"

namespace rubicon::tuples {

namespace {

constexpr std::size_t kEventsPerTurn = 20'000;
constexpr std::size_t kNodesPerTurn = 20'000;
constexpr Duration kLinkRetry = std::chrono::milliseconds(1);

}  // namespace

TupleSpace::Impl::Impl(OwnerId id, Scheduler& sched, Link& far)
    : self(id),
      scheduler(sched),
      link(far),
      store(id),
      queue(store),
      outbox(store, link,
             [this](const PeerQueue& peer, std::uint32_t subscription) { return has(peer, subscription); }),
      demand(store, id),
      deadlines(
          sched, [this](const Deadline& deadline, SteadyTime at) { on_deadline(deadline, at); },
          [this](const Deadline& deadline) { return still_matters(deadline); }),
      expiry(deadlines, store),
      pacer(deadlines, store),
      requests(id, sched),
      walk_budget(kNodesPerTurn) {
  store.judge_by([this](const SubscriptionPtr& one, std::string_view key) { return judged(one, key); });
}

/// The clocks are read once per turn: all writes of a turn have the same time.
void TupleSpace::Impl::open_turn() {
  RUBICON_DEBUG_ASSERT(scheduler.on_loop_thread());
  if (turn_is_open) return;
  turn_is_open = true;
  now = scheduler.now();
  wall = scheduler.wall_now();
  if (!turn_is_ending) later([this] { end_turn(); });
}

/// Writes by the callbacks that run here begin a turn of their own, with a later time, but are sent with this one.
void TupleSpace::Impl::end_turn() {
  turn_is_open = false;
  turn_is_ending = true;
  walk_budget = kNodesPerTurn;
  run_walks();
  queue.drain(kEventsPerTurn);
  demand.drain();
  turn_is_open = turn_is_ending = false;
  flush_outbox();
  store.sets().collect();
  if (queue.size() > 0 || !walks.empty() || demand.pending()) open_turn();
}

void TupleSpace::Impl::flush_outbox() {
  if (outbox.empty() || outbox_retry.pending()) return;
  const auto state = outbox.flush();
  if (state == Outbox::State::kMore) open_turn();
  if (state == Outbox::State::kNoRoom) outbox_retry = scheduler.after(kLinkRetry, [this] { flush_outbox(); });
}

std::uint32_t TupleSpace::Impl::find(OwnerId owner, std::string_view key) {
  const auto index = store.find(owner, key);
  if (index == kNone || erasing == 0 || !pending_erase(index)) return index;
  remove(index, EventKind::kDeleted);
  return kNone;
}

/// Whether the tuple matches an erase by pattern that has not reached it yet.
bool TupleSpace::Impl::pending_erase(std::uint32_t index) const {
  const auto& tuple = store.at(index);
  return erasing > 0 && std::any_of(walks.begin(), walks.end(), [&](const auto& walk) {
           return walk->purpose == Walk::Purpose::kErase && walk->is_older(tuple) &&
                  walk->pattern.matches(tuple.owner, tuple.key());
         });
}

void TupleSpace::Impl::announce(std::uint32_t index, EventKind kind) {
  const auto& subscribers_now = store.subscribers(index);
  if (!subscribers_now.plain.empty()) queue.push(index, kind);
  for (auto* peer : subscribers_now.peers) outbox.add(*peer, index);
  for (auto* subscription : subscribers_now.paced) pace(*subscription, index, kind);
}

void TupleSpace::Impl::pace(Subscription& subscription, std::uint32_t index, EventKind kind) {
  if (!subscription.alive) return;
  if (kind == EventKind::kSet && !pacer.offer(subscription, index, now)) return;
  deliver(by_number.at(subscription.number), index, kind);
}

void TupleSpace::Impl::deliver(const SubscriptionPtr& subscription, std::uint32_t index, EventKind kind) {
  if (subscription->local()) {
    queue.push_to(index, kind, subscription);
  } else {
    outbox.add(*subscription->peer, index);
  }
}

void TupleSpace::Impl::remove(std::uint32_t index, EventKind how) {
  open_turn();
  auto& tuple = store.at(index);
  const bool own = tuple.owner == self;
  const auto demand_before = store.subscribers(index).demand;
  store.pool().pin(index);
  announce(index, how);
  if (tuple.expires) expiry.clear(index);
  store.remove(index, how);
  if (own) demand.note(index, demand_before);
  store.pool().unpin(index);
}

bool TupleSpace::Impl::still_matters(const Deadline& deadline) const {
  if (!store.is_present({deadline.tuple, deadline.generation})) return false;
  if (deadline.subscription == 0) return expiry.is_armed(deadline);
  const auto found = by_number.find(deadline.subscription);
  return found != by_number.end() && Pacer::is_armed(*found->second, deadline);
}

void TupleSpace::Impl::on_deadline(const Deadline& deadline, SteadyTime at) {
  if (!still_matters(deadline)) return;
  if (deadline.subscription == 0) {
    if (expiry.is_due(deadline.tuple, at)) remove(deadline.tuple, EventKind::kExpired);
    return;
  }
  const auto& subscription = by_number.at(deadline.subscription);
  const auto due = pacer.due(*subscription, deadline.tuple, at);
  if (due == Pacer::Due::kNothing) return;
  // A heartbeat means that the owner is present and the value is still valid.
  if (due == Pacer::Due::kHeartbeat && absent.contains(store.at(deadline.tuple).owner)) return;
  open_turn();
  deliver(subscription, deadline.tuple, EventKind::kSet);
}

Result<TupleRef> TupleSpace::Impl::write(std::string_view key, std::string_view value, const SetOptions& options,
                                         OwnerId creator) {
  if (value.size() > kMaxValueSize) {
    return fail(ErrorCode::kOutOfRange, fmt::format("setting {}: the value has {} bytes, at most {} are allowed",
                                                    model::quoted(key), value.size(), kMaxValueSize));
  }
  auto index = find(self, key);
  if (auto ok = check_sequence(key, index, options); !ok) return fail(std::move(ok.error()));
  if (index == kNone) {
    if (auto ok = model::check_key(key); !ok) return fail(ok.error());
    index = store.create(self, key);
    demand.note(index, {});
  }
  write(index, value, options, creator);
  return TupleRef{index, store.at(index).generation};
}

void TupleSpace::Impl::write(std::uint32_t index, std::string_view value, const SetOptions& options, OwnerId creator) {
  open_turn();
  auto& tuple = store.at(index);
  store.set_value(tuple, value);
  set_media_type(tuple, options.media_type);
  stamp(tuple, options, creator);
  if (options.lifetime > Duration(0)) {
    live_for(index, options.lifetime);
  } else if (tuple.expires) {
    store.set_expire_time(index, {});
    expiry.clear(index);
  }
  announce(index, EventKind::kSet);
}

Result<TupleRef> TupleSpace::Impl::append(std::string_view key, std::string_view bytes, const SetOptions& options,
                                          OwnerId creator) {
  const auto index = find(self, key);
  if (auto ok = check_append(key, index, bytes.size(), options); !ok) return fail(std::move(ok.error()));
  open_turn();
  auto& tuple = store.at(index);
  tuple.value.append(bytes);
  stamp(tuple, options, creator);
  if (options.lifetime > Duration(0)) live_for(index, options.lifetime);
  announce(index, EventKind::kSet);
  return TupleRef{index, tuple.generation};
}

Result<void> TupleSpace::Impl::check_sequence(std::string_view key, std::uint32_t index,
                                              const SetOptions& options) const {
  if (!options.expected_sequence) return {};
  const auto expected = *options.expected_sequence;
  const auto present = index == kNone ? 0 : store.at(index).sequence;
  if (expected == present) return {};
  const auto text_of = [](std::uint64_t sequence) {
    return sequence == 0 ? std::string("no such tuple") : fmt::format("sequence {}", sequence);
  };
  return fail(ErrorCode::kRefused, fmt::format("writing {}: expected {}, found {}", model::quoted(key),
                                               text_of(expected), text_of(present)));
}

Result<void> TupleSpace::Impl::check_append(std::string_view key, std::uint32_t index, std::size_t more,
                                            const SetOptions& options) const {
  if (auto ok = check_sequence(key, index, options); !ok) return ok;
  if (index == kNone) {
    return fail(ErrorCode::kNotFound, fmt::format("appending to {}: no such tuple", model::quoted(key)));
  }
  const auto& tuple = store.at(index);
  const auto media_type = store.media_types().name(tuple.media_type);
  if (!options.media_type.empty() && options.media_type != media_type) {
    return fail(ErrorCode::kInvalid, fmt::format("appending to {}: expected its media type {}, got {}",
                                                 model::quoted(key), media_type, model::quoted(options.media_type)));
  }
  if (more <= kMaxValueSize && tuple.value.size() <= kMaxValueSize - more) return {};
  return fail(ErrorCode::kOutOfRange,
              fmt::format("appending to {}: {} bytes after the present {}, expected at most {} in total",
                          model::quoted(key), more, tuple.value.size(), kMaxValueSize));
}

void TupleSpace::Impl::stamp(Tuple& tuple, const SetOptions& options, OwnerId creator) {
  ++tuple.sequence;
  tuple.creator = creator;
  tuple.write_time = wall;
  tuple.user_time = options.user_time;
  ++sets;
}

void TupleSpace::Impl::live_for(std::uint32_t index, Duration lifetime) {
  lifetime = std::min(lifetime, kMaxDuration);
  store.set_expire_time(index, wall + std::chrono::ceil<std::chrono::microseconds>(lifetime));
  expiry.set(index, lifetime, now);
}

void TupleSpace::Impl::set_media_type(Tuple& tuple, std::string_view name) {
  if (store.media_types().name(tuple.media_type) == name) return;
  tuple.media_type = store.media_types().intern(name);
}

}  // namespace rubicon::tuples
