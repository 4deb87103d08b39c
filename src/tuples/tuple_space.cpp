#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/assert.h"
#include "rubicon/tuple.hpp"
#include "rubicon/tuple_space.hpp"
#include "tuples/space_impl.h"

namespace rubicon::tuples {

std::string_view to_string(EventKind kind) {
  switch (kind) {
    case EventKind::kSet: return "set";
    case EventKind::kDeleted: return "deleted";
    case EventKind::kExpired: return "expired";
    case EventKind::kLost: return "lost";
  }
  base::assertion_failed("EventKind in range", __FILE__, __LINE__);
}

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kApplied: return "applied";
    case Verdict::kRefused: return "refused";
    case Verdict::kExpired: return "expired";
    case Verdict::kNoSuchOwner: return "no-such-owner";
    case Verdict::kTimedOut: return "timed-out";
  }
  base::assertion_failed("Verdict in range", __FILE__, __LINE__);
}

namespace {

constexpr Duration kDefaultTimeToLive = std::chrono::seconds(5);
constexpr std::size_t kNoBudget = std::numeric_limits<std::size_t>::max();

RemoteSet remote_set_of(OwnerId owner, std::string_view key, std::string_view value, Duration time_to_live,
                        const SetOptions& options) {
  RemoteSet set;
  set.owner = owner;
  set.key = key;
  set.value = value;
  set.media_type = options.media_type;
  set.user_time = options.user_time;
  set.lifetime = options.lifetime;
  set.time_to_live = time_to_live > Duration(0) ? std::min(time_to_live, kMaxDuration) : kDefaultTimeToLive;
  set.time_to_live_given = true;  // the default is documented, so the owner must not use another
  set.expected_sequence = options.expected_sequence;
  set.asker = options.asker;
  return set;
}

}  // namespace

void Handle::reset() {
  if (auto end = std::exchange(end_, nullptr)) end();
}

Handle& Handle::operator=(Handle&& other) noexcept {
  if (this != &other) {
    reset();
    end_ = std::exchange(other.end_, nullptr);
  }
  return *this;
}

TupleSpace::TupleSpace(OwnerId self, base::Scheduler& scheduler, Link& link)
    : impl_(std::make_unique<Impl>(self, scheduler, link)) {
  link.attach(*impl_, static_cast<std::uint64_t>(scheduler.wall_now().time_since_epoch().count()));
}

TupleSpace::~TupleSpace() {
  impl_->link.detach();
}

OwnerId TupleSpace::self() const {
  return impl_->self;
}

Result<TupleRef> TupleSpace::declare(std::string_view key, std::string_view value, const SetOptions& options) {
  if (const auto there = find(key)) return *there;
  return set(key, value, options);
}

Result<TupleRef> TupleSpace::set(std::string_view key, std::string_view value, const SetOptions& options) {
  return impl_->write(key, value, options, impl_->self);
}

Result<void> TupleSpace::set(TupleRef tuple, std::string_view value, const SetOptions& options) {
  auto& impl = *impl_;
  if (!impl.store.is_present(tuple) || impl.pending_erase(tuple.index)) {
    return fail(ErrorCode::kNotFound, "set by reference: the tuple was deleted or has expired");
  }
  if (value.size() > kMaxValueSize || options.expected_sequence) {
    const auto key = impl.store.at(tuple.index).key();
    return impl.write(key, value, options, impl.self).map([](TupleRef) {});
  }
  impl.write(tuple.index, value, options, impl.self);
  return {};
}

Result<void> TupleSpace::append(std::string_view key, std::string_view bytes, const SetOptions& options) {
  return impl_->append(key, bytes, options, impl_->self).map([](TupleRef) {});
}

Result<void> TupleSpace::append(TupleRef tuple, std::string_view bytes, const SetOptions& options) {
  auto& impl = *impl_;
  if (!impl.store.is_present(tuple) || impl.pending_erase(tuple.index)) {
    return fail(ErrorCode::kNotFound, "append by reference: the tuple was deleted or has expired");
  }
  return append(impl.store.at(tuple.index).key(), bytes, options);
}

Result<void> TupleSpace::erase(std::string_view key) {
  const auto index = impl_->find(impl_->self, key);
  if (index == kNone) return fail(ErrorCode::kNotFound, fmt::format("erasing {}: no such tuple", model::quoted(key)));
  impl_->remove(index, EventKind::kDeleted);
  return {};
}

void TupleSpace::erase(const Pattern& pattern) {
  if (!is_sound(pattern) || (pattern.owner && *pattern.owner != impl_->self)) return;
  impl_->open_turn();
  impl_->walk(Walk::Purpose::kErase, {impl_->self, pattern.key}, nullptr);
}

std::optional<TupleRef> TupleSpace::find(std::string_view key) const {
  const auto index = impl_->find(impl_->self, key);
  if (index == kNone) return std::nullopt;
  return TupleRef{index, impl_->store.at(index).generation};
}

bool TupleSpace::has_subscriber(TupleRef tuple) const {
  if (!impl_->store.is_present(tuple)) return false;
  const auto& members = impl_->store.subscribers(tuple.index).members;
  return std::any_of(members.begin(), members.end(), [](const auto& member) {
    return member->alive && (member->local() || member->peer->id != kLinkItself);
  });
}

Handle TupleSpace::watch_demand(const Pattern& pattern, DemandCall call) {
  if (!is_sound(pattern)) return {};
  impl_->open_turn();
  return impl_->handle(
      [impl = impl_.get(), watch = impl_->demand.add(pattern, std::move(call))] { impl->demand.remove(watch); });
}

Handle TupleSpace::add_policy(const Pattern& pattern, SetPolicy policy, PolicyScope scope) {
  if (!is_sound(pattern)) return {};
  return impl_->handle([impl = impl_.get(), entry = impl_->policies.add(pattern, std::move(policy), scope)] {
    impl->policies.remove(entry);
  });
}

Handle TupleSpace::subscribe(const Pattern& pattern, const Flow& flow, EventCall call, SnapshotCall snapshot) {
  if (!is_sound(pattern)) return {};
  auto& impl = *impl_;
  const auto id = impl.free_wire_id();
  const auto subscription = impl.subscribe(pattern, flow, std::move(call), nullptr, id);
  subscription->snapshot = std::move(snapshot);
  impl.by_wire_id.emplace(id, subscription);
  const bool others = !pattern.owner || *pattern.owner != impl.self;
  if (others) impl.link.subscribe({id, pattern, subscription->flow});
  return impl.handle([&impl, subscription, others] {
    impl.by_wire_id.erase(subscription->wire_id);
    if (others) impl.link.unsubscribe(subscription->wire_id);
    impl.unsubscribe(subscription);
  });
}

std::uint64_t TupleSpace::set_remote(OwnerId owner, std::string_view key, std::string_view value, Duration time_to_live,
                                     ReplyCall call, const SetOptions& options) {
  return impl_->start_request(remote_set_of(owner, key, value, time_to_live, options), std::move(call));
}

std::uint64_t TupleSpace::append_remote(OwnerId owner, std::string_view key, std::string_view bytes,
                                        Duration time_to_live, ReplyCall call, const SetOptions& options) {
  auto set = remote_set_of(owner, key, bytes, time_to_live, options);
  set.append = true;
  return impl_->start_request(std::move(set), std::move(call));
}

std::optional<TupleView> TupleSpace::get(OwnerId owner, std::string_view key) const {
  const auto index = impl_->find(owner, key);
  if (index == kNone) return std::nullopt;
  auto view = impl_->store.view(index);
  view.owner_present = !impl_->absent.contains(owner);
  return view;
}

void TupleSpace::list(const Pattern& pattern, const std::function<void(const TupleView&)>& visit) const {
  if (!is_sound(pattern)) return;
  auto& store = impl_->store;
  PatternWalk walk(store.trie(), pattern);
  auto budget = kNoBudget;
  while (const auto index = walk.next(budget)) {
    if (impl_->pending_erase(*index)) continue;
    store.pool().pin(*index);
    auto view = store.view(*index);
    view.owner_present = !impl_->absent.contains(view.owner);
    visit(view);
    store.pool().unpin(*index);
  }
}

std::vector<OwnerId> TupleSpace::peers() const {
  return impl_->link.peers();
}

Handle TupleSpace::watch_peers(PeerCall call) {
  auto watch = impl_->peer_calls.emplace_back(std::make_shared<PeerCall>(std::move(call)));
  return impl_->handle([impl = impl_.get(), watch] { std::erase(impl->peer_calls, watch); });
}

Result<void> TupleSpace::describe(std::string_view summary) {
  if (summary.size() > kMaxSummary)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("summary of {} bytes: expected at most {}", summary.size(), kMaxSummary));
  impl_->link.describe(std::string(summary));
  return {};
}

std::string_view TupleSpace::summary(OwnerId peer) const {
  const auto found = impl_->summaries.find(peer);
  return found == impl_->summaries.end() ? std::string_view() : std::string_view(found->second);
}

Handle TupleSpace::watch_summaries(SummaryCall call) {
  auto watch = impl_->summary_calls.emplace_back(std::make_shared<SummaryCall>(std::move(call)));
  return impl_->handle([impl = impl_.get(), watch] { std::erase(impl->summary_calls, watch); });
}

TupleSpace::Stats TupleSpace::stats() const {
  const auto& impl = *impl_;
  return {impl.store.own(),
          impl.store.cached(),
          impl.by_number.size(),
          impl.queue.size() + impl.outbox.size(),
          impl.sets,
          impl.queue.delivered(),
          impl.queue.merged() + impl.outbox.merged(),
          impl.queue.dropped() + impl.outbox.dropped() + impl.dropped,
          impl.refused};
}

}  // namespace rubicon::tuples
