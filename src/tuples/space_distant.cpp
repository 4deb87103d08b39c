#include <fmt/format.h>

#include <algorithm>

#include "base/assert.h"
#include "tuples/peer_policy.h"
#include "tuples/space_impl.h"

namespace rubicon::tuples {

namespace {

/// How long a copy lives from now on: the lifetime that the owner gave the tuple, independent of the wall clocks.
Duration lifetime_of(const TupleView& tuple) {
  if (tuple.expire_time == WallTime{}) return Duration(0);
  const auto from = static_cast<double>(tuple.write_time.time_since_epoch().count());
  const auto to = static_cast<double>(tuple.expire_time.time_since_epoch().count());
  const auto longest = std::chrono::duration<double, std::micro>(kMaxDuration).count();
  if (to - from >= longest) return kMaxDuration;
  if (to <= from) return Duration(1);
  return std::chrono::microseconds(static_cast<std::int64_t>(to - from));
}

/// A call may end any of the watches.
template <class Call, class... Arguments>
void call_all(const std::vector<std::shared_ptr<Call>>& calls, Arguments... arguments) {
  for (const auto& call : std::vector(calls)) {
    if (std::find(calls.begin(), calls.end(), call) != calls.end()) (*call)(arguments...);
  }
}

}  // namespace

void TupleSpace::Impl::apply(OwnerId owner, const TupleSet& change) {
  const auto& tuple = change.tuple;
  if (tuple.value.size() > kMaxValueSize) {
    ++dropped;
    return;
  }
  auto index = store.find(owner, tuple.key);
  if (index != kNone) return update_copy(index, tuple);
  if (store.cached() >= kMaxCached || tuple.sequence == 0 || !model::check_key(tuple.key)) {
    ++dropped;
    return;
  }
  index = store.create(owner, tuple.key);
  // Sent before the owner knew that the last subscription here ended.
  if (store.at(index).subscribers == 0) return store.remove(index, EventKind::kDeleted);
  update_copy(index, tuple);
}

void TupleSpace::Impl::apply(OwnerId owner, const TupleGone& change) {
  const auto index = store.find(owner, change.key);
  if (index != kNone) remove(index, change.how);
}

/// Drops old and repeated values; in a new epoch of the owner each value counts, whatever its sequence.
void TupleSpace::Impl::update_copy(std::uint32_t index, const TupleView& news) {
  auto& tuple = store.at(index);
  const auto epoch = epochs[tuple.owner];
  const bool confirmed = tuple.epoch == epoch;
  tuple.epoch = epoch;
  if (confirmed && news.sequence <= tuple.sequence) return;
  if (news.sequence == tuple.sequence && news.write_time == tuple.write_time && news.value == tuple.value.view())
    return;
  store.set_value(tuple, news.value);
  set_media_type(tuple, news.media_type);
  tuple.sequence = news.sequence;
  tuple.creator = news.creator;
  tuple.write_time = news.write_time;
  tuple.user_time = news.user_time;
  const auto lifetime = lifetime_of(news);
  if (tuple.expires && lifetime <= Duration(0)) expiry.clear(index);
  store.set_expire_time(index, news.expire_time);
  if (lifetime > Duration(0)) expiry.set(index, lifetime, now);
  announce(index, EventKind::kSet);
}

void TupleSpace::Impl::apply(OwnerId owner, const SnapshotEnd& end) {
  const auto found = by_wire_id.find(end.subscription);
  if (found == by_wire_id.end()) return;
  const auto& subscription = found->second;
  walk(Walk::Purpose::kReconcile, {owner, subscription->pattern.key}, nullptr);
  if (!subscription->snapshot) return;
  later([subscription, owner] {
    if (subscription->alive) subscription->snapshot(owner);
  });
}

void TupleSpace::Impl::drop_peer(OwnerId peer) {
  const auto node = subscribers.extract(peer);
  if (!node) return;
  outbox.close(*node.mapped().outgoing);
  for (const auto& [id, subscription] : node.mapped().subscriptions) unsubscribe(subscription);
}

bool TupleSpace::Impl::has(const PeerQueue& peer, std::uint32_t subscription) const {
  const auto found = subscribers.find(peer.id);
  return found != subscribers.end() && found->second.outgoing.get() == &peer &&
         found->second.subscriptions.contains(subscription);
}

void TupleSpace::Impl::on_changes(OwnerId owner, std::span<const Change> changes) {
  open_turn();
  if (owner == self) {
    dropped += changes.size();
    return;
  }
  for (const auto& change : changes) std::visit([&](const auto& one) { apply(owner, one); }, change);
}

void TupleSpace::Impl::on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) {
  if (spec.pattern.owner && *spec.pattern.owner != self) return;
  auto& peer = subscribers[subscriber];
  if (!peer.outgoing) {
    peer.outgoing = std::make_shared<PeerQueue>();
    peer.outgoing->id = subscriber;
    outbox.add(*peer.outgoing, next_restart());
  }
  on_unsubscribe(subscriber, spec.id);
  if (!link.policy().may_subscribe(subscriber, spec)) {
    ++refused;
    return;
  }
  if (!is_sound(spec.pattern) || peer.subscriptions.size() >= kMaxSubscriptionsPerPeer) {
    ++dropped;
    return;
  }
  peer.subscriptions[spec.id] = subscribe(spec.pattern, spec.flow, {}, peer.outgoing, spec.id);
}

Restart TupleSpace::Impl::next_restart() {
  last_restart = std::max(scheduler.wall_now(), last_restart + std::chrono::microseconds(1));
  return {last_restart};
}

void TupleSpace::Impl::on_unsubscribe(OwnerId subscriber, std::uint32_t id) {
  const auto peer = subscribers.find(subscriber);
  if (peer == subscribers.end()) return;
  const auto node = peer->second.subscriptions.extract(id);
  if (node) unsubscribe(node.mapped());
}

/// Rights are asked about what may be a tuple only. The audit gets the beginning of any other key.
void TupleSpace::Impl::refuse_unsound(const RemoteSet& set, const Error& why) {
  RemoteSet shortened;
  shortened.from = set.from;
  shortened.owner = set.owner;
  shortened.request = set.request;
  shortened.key = set.key.substr(0, model::kMaxKeyLength);
  shortened.append = set.append;
  const Reply reply{set.from, set.request, Verdict::kRefused, why.code, why.text};
  link.policy().answered(shortened, reply);
  link.reply(reply);
}

void TupleSpace::Impl::on_remote_set(const RemoteSet& set) {
  if (const auto sound = check_sizes(set); !sound) return refuse_unsound(set, sound.error());
  auto& policy = link.policy();
  auto may = policy.may_set(set);
  if (!may) ++refused;
  std::shared_ptr<const RemoteSet> meant;
  const auto reply =
      may ? answer(set, meant) : Reply{set.from, set.request, Verdict::kRefused, may.error().code, may.error().text};
  policy.answered(meant ? *meant : set, reply);
  link.reply(reply);
}

bool TupleSpace::Impl::on_reply(OwnerId from, const Reply& reply) {
  const bool is_owner = requests.answer(from, reply);
  if (!is_owner) ++dropped;
  return is_owner;
}

void TupleSpace::Impl::peer_up(OwnerId owner) {
  absent.erase(owner);
  begin_epoch(owner);
}

/// From now on each value of the owner counts, and the end of a snapshot removes copies that it did not contain. Needed
/// because we may not notice that the owner had lost us.
void TupleSpace::Impl::begin_epoch(OwnerId owner) {
  if (store.trie().has_owner(owner)) {
    ++epochs[owner];
  } else {
    epochs.erase(owner);  // without copies there is nothing to reconcile
  }
}

/// Copies stay readable for kOwnerGrace: if the owner returns soon, no subscriber notices.
void TupleSpace::Impl::peer_down(OwnerId owner) {
  drop_peer(owner);
  summaries.erase(owner);
  const auto has_no_copies = [this](const auto& one) { return !store.trie().has_owner(one.first); };
  std::erase_if(absent, has_no_copies);
  std::erase_if(epochs, has_no_copies);
  if (!store.trie().has_owner(owner)) return;
  absent[owner] = scheduler.after(kOwnerGrace, [this, owner] {
    open_turn();
    walk(Walk::Purpose::kForget, {owner, "**"}, nullptr);
  });
}

void TupleSpace::Impl::on_peer(const PeerIdentity& peer, PeerEvent event) {
  if (event == PeerEvent::kUp) {
    peer_up(peer.id);
  } else {
    peer_down(peer.id);
  }
  call_all(peer_calls, peer.id, event);
}

void TupleSpace::Impl::on_summary(OwnerId peer, std::string_view summary) {
  if (summary.size() > kMaxSummary) {
    ++dropped;
    return;
  }
  summaries[peer] = summary;
  call_all(summary_calls, peer, summary);
}

namespace {

/// Between two looks whether the owners of sets that wait were found.
constexpr Duration kSeekStep = std::chrono::milliseconds(5), kLongSeekStep = std::chrono::milliseconds(100);

SetOptions options_of(const RemoteSet& set) {
  return {set.media_type, set.user_time, set.lifetime, set.expected_sequence};
}

}  // namespace

std::uint64_t TupleSpace::Impl::start_request(RemoteSet&& set, ReplyCall call) {
  RUBICON_DEBUG_ASSERT(scheduler.on_loop_thread());
  set.from = self;
  const auto request = set.request = requests.next_number();
  if (requests.full()) {
    later([request, me = self, call = std::move(call)] {
      if (call) call({me, request, Verdict::kRefused, ErrorCode::kBusy, "too many remote sets wait for their replies"});
    });
    return request;
  }
  requests.open(request, set.owner, set.time_to_live, std::move(call));
  send(std::move(set));
  return request;
}

void TupleSpace::Impl::send(RemoteSet&& set) {
  if (set.owner == self) {
    later([this, set = std::move(set)] { answer_own(set); });
  } else if (sought.has(set.owner)) {
    hold(set);
  } else if (auto sent = link.remote_set(set); !sent) {
    const bool may_come = sent.error().code == ErrorCode::kNotFound && link.seeks(set.owner);
    may_come ? hold(set) : refuse(set, sent.error());
  }
}

void TupleSpace::Impl::refuse(const RemoteSet& set, const Error& why) {
  const auto verdict = why.code == ErrorCode::kNotFound ? Verdict::kNoSuchOwner : Verdict::kRefused;
  later([this, owner = set.owner, reply = Reply{self, set.request, verdict, why.code, why.text}] {
    requests.answer(owner, reply);
  });
}

/// Until the link has found the owner, or knows that it is not there.
void TupleSpace::Impl::hold(const RemoteSet& set) {
  if (!sought.hold(set, scheduler.now()))
    return refuse(set, {ErrorCode::kBusy, "too many remote sets wait for their owners"});
  requests.set_left(set.request, false);
  seek_step = kSeekStep;
  sought_due.advance_to(scheduler.now() + seek_step);
}

void TupleSpace::Impl::release_sought() {
  const auto alive = lifetime.watch();
  seek_step = std::min(2 * seek_step, kLongSeekStep);
  sought.drop_ended(scheduler.now());
  for (const auto owner : sought.owners()) {
    if (link.seeks(owner)) {
      sought_due.advance_to(scheduler.now() + seek_step);
      continue;
    }
    for (auto& set : sought.take(owner, scheduler.now())) {
      requests.set_left(set.request, true);
      send(std::move(set));
      if (alive.ended()) return;
    }
  }
}

Result<void> TupleSpace::Impl::check_sizes(const RemoteSet& set) {
  if (auto ok = model::check_key(set.key); !ok) return ok;
  if (set.value.size() <= kMaxValueSize) return {};
  return fail(ErrorCode::kOutOfRange, fmt::format("the value for {} has {} bytes, at most {} are allowed", set.key,
                                                  set.value.size(), kMaxValueSize));
}

/// The sizes of sets of others were checked when they came.
SetDecision TupleSpace::Impl::decide(const RemoteSet& set) {
  if (auto ok = set.from == self ? check_sizes(set) : Result<void>(); !ok) return SetDecision::refused(ok.error());
  const auto policy = policies.find(self, set.key);
  const auto index = find(self, set.key);
  if (!policy && index == kNone) {
    return SetDecision::refused({ErrorCode::kNotFound, fmt::format("{} has no tuple {}", number(self), set.key)});
  }
  if (!policy)
    return SetDecision::refused({ErrorCode::kRefused, fmt::format("{} is read-only for other components", set.key)});
  if (set.append && policy->scope != PolicyScope::kSetsAndAppends) {
    return SetDecision::refused(
        {ErrorCode::kRefused, fmt::format("{} accepts whole values only, not appends", set.key)});
  }
  const auto options = options_of(set);
  const auto fits =
      set.append ? check_append(set.key, index, set.value.size(), options) : check_sequence(set.key, index, options);
  return fits ? policy->policy(set) : SetDecision::refused(fits.error());
}

Reply TupleSpace::Impl::answer(const RemoteSet& set, std::shared_ptr<const RemoteSet>& meant) {
  auto decision = set.time_to_live < Duration(0)
                      ? SetDecision{Verdict::kExpired,
                                    false,
                                    ErrorCode::kExpired,
                                    "the time to live ended before the owner received the request",
                                    {}}
                      : decide(set);
  const bool store_it = decision.verdict == Verdict::kApplied && decision.store;
  auto index = kNone;
  if (store_it) {
    const auto stored = set.append ? append(set.key, set.value, options_of(set), set.from)
                                   : write(set.key, set.value, options_of(set), set.from);
    if (stored) index = stored->index;
    if (!stored) decision = SetDecision::refused(stored.error());
  }
  meant = std::move(decision.meant);
  Reply reply{set.from, set.request, decision.verdict, decision.code, std::move(decision.text)};
  if (index == kNone && (store_it || set.expected_sequence)) index = find(self, set.key);
  if (index != kNone) reply.sequence = store.at(index).sequence;
  return reply;
}

void TupleSpace::Impl::answer_own(RemoteSet set) {
  const auto remaining = requests.remaining(set.request);
  if (!remaining) return;
  // Exactly zero remains: pass a negative time, because zero means that none was given.
  set.time_to_live = *remaining > Duration(0) ? *remaining : Duration(-1);
  std::shared_ptr<const RemoteSet> meant;
  requests.answer(self, answer(set, meant));
}

}  // namespace rubicon::tuples
