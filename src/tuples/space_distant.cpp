#include <algorithm>

#include "tuples/peer_policy.h"
#include "tuples/space_impl.h"

namespace rubicon::tuples {

namespace {

/// How long a copy lives from now on: what the owner gave the tuple, whatever the two wall clocks say.
Duration lifetime_of(const TupleView& tuple) {
  if (tuple.expire_time == WallTime{}) return Duration(0);
  const auto from = static_cast<double>(tuple.write_time.time_since_epoch().count());
  const auto to = static_cast<double>(tuple.expire_time.time_since_epoch().count());
  const auto longest = std::chrono::duration<double, std::micro>(kLongest).count();
  if (to - from >= longest) return kLongest;
  if (to <= from) return Duration(1);
  return std::chrono::microseconds(static_cast<std::int64_t>(to - from));
}

/// The calls may end any of the watches.
template <class Call, class... Arguments>
void tell(const std::vector<std::shared_ptr<Call>>& calls, Arguments... arguments) {
  for (const auto& call : std::vector(calls)) {
    if (std::find(calls.begin(), calls.end(), call) != calls.end()) (*call)(arguments...);
  }
}

}  // namespace

void TupleSpace::Impl::take_change(OwnerId owner, const Change& change) {
  const auto& tuple = change.tuple;
  if (owner == self || tuple.value.size() > kMaxValueSize) {
    ++dropped;
    return;
  }
  if (tuple.key.empty()) {
    // Who was lost to the owner does not always notice: deletions of that time are found at the end of the snapshot.
    if (tuple.sequence == 0) return confirm_anew(owner);
    end_snapshot(owner, static_cast<std::uint32_t>(tuple.sequence));
    return;
  }
  auto index = store.find(owner, tuple.key);
  if (change.kind != EventKind::kSet) {
    if (index != kNone) remove(index, change.kind);
    return;
  }
  if (index != kNone) {
    take_value(index, change);
    return;
  }
  if (store.cached() >= kMaxCached || tuple.sequence == 0 || !model::check_key(tuple.key)) {
    ++dropped;
    return;
  }
  index = store.create(owner, tuple.key);
  // Late news of what nobody here wants any more.
  if (store.at(index).subscribers == 0) return store.remove(index, EventKind::kDeleted);
  take_value(index, change);
}

/// Old news and repetitions are dropped, except after the owner came back: then its word counts, whatever the number.
void TupleSpace::Impl::take_value(std::uint32_t index, const Change& change) {
  auto& tuple = store.at(index);
  const auto epoch = epochs[tuple.owner];
  const bool confirmed = tuple.epoch == epoch;
  const auto& news = change.tuple;
  tuple.epoch = epoch;
  if (confirmed && news.sequence <= tuple.sequence) return;
  if (news.sequence == tuple.sequence && news.write_time == tuple.write_time && news.value == tuple.value) return;
  tuple.value.assign(news.value);
  set_media_type(tuple, news.media_type);
  tuple.sequence = news.sequence;
  tuple.creator = news.creator;
  tuple.write_time = news.write_time;
  tuple.user_time = news.user_time;
  expiry.clear(index);
  tuple.expire_time = news.expire_time;
  if (const auto lifetime = lifetime_of(news); lifetime > Duration(0)) expiry.set(index, lifetime, now);
  announce(index, EventKind::kSet);
}

void TupleSpace::Impl::end_snapshot(OwnerId owner, std::uint32_t wire_id) {
  const auto found = by_wire_id.find(wire_id);
  if (found == by_wire_id.end()) return;
  const auto& subscription = found->second;
  walk(Walk::Aim::kReconcile, {owner, subscription->pattern.key}, nullptr);
  if (!subscription->snapshot) return;
  later([subscription, owner] {
    if (subscription->alive) subscription->snapshot(owner);
  });
}

void TupleSpace::Impl::drop_peer(OwnerId peer) {
  const auto node = subscribers.extract(peer);
  if (!node) return;
  outbox.forget(*node.mapped().box);
  for (const auto& [id, subscription] : node.mapped().subscriptions) unsubscribe(subscription);
}

void TupleSpace::Impl::on_changes(OwnerId owner, std::span<const Change> changes) {
  open_turn();
  for (const auto& change : changes) take_change(owner, change);
}

void TupleSpace::Impl::on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) {
  if (spec.pattern.owner && *spec.pattern.owner != self) return;
  auto& peer = subscribers[subscriber];
  if (!peer.box) {
    peer.box = std::make_shared<PeerBox>();
    peer.box->id = subscriber;
    outbox.mark_beginning(*peer.box);
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
  peer.subscriptions[spec.id] = subscribe(spec.pattern, spec.flow, {}, peer.box, spec.id);
}

void TupleSpace::Impl::on_unsubscribe(OwnerId subscriber, std::uint32_t id) {
  const auto peer = subscribers.find(subscriber);
  if (peer == subscribers.end()) return;
  const auto node = peer->second.subscriptions.extract(id);
  if (node) unsubscribe(node.mapped());
}

void TupleSpace::Impl::on_remote_set(const RemoteSet& wish) {
  if (auto may = link.policy().may_set(wish); !may) {
    ++refused;
    return link.reply({wish.from, wish.request, Verdict::kRefused, may.error().code, std::move(may.error().text)});
  }
  link.reply(judge(wish));
}

void TupleSpace::Impl::on_reply(const Reply& reply) {
  requests.answer(reply);
}

void TupleSpace::Impl::came(OwnerId owner) {
  absent.erase(owner);
  confirm_anew(owner);
}

void TupleSpace::Impl::confirm_anew(OwnerId owner) {
  if (store.trie().has_owner(owner)) {
    ++epochs[owner];
  } else {
    epochs.erase(owner);  // without copies there is nothing to reconcile
  }
}

/// Its copies stay readable for a while: who comes back soon disturbs nobody.
void TupleSpace::Impl::went(OwnerId owner) {
  drop_peer(owner);
  summaries.erase(owner);
  std::erase_if(absent, [this](const auto& one) { return !store.trie().has_owner(one.first); });
  if (!store.trie().has_owner(owner)) return void(epochs.erase(owner));
  absent[owner] = scheduler.after(kOwnerGrace, [this, owner] {
    open_turn();
    walk(Walk::Aim::kForget, {owner, "**"}, nullptr);
  });
}

void TupleSpace::Impl::on_peer(OwnerId peer, PeerEvent event) {
  event == PeerEvent::kUp ? came(peer) : went(peer);
  tell(peer_calls, peer, event);
}

void TupleSpace::Impl::on_summary(OwnerId peer, std::string_view summary) {
  if (summary.size() > kMaxSummary) return void(++dropped);
  summaries[peer] = summary;
  tell(summary_calls, peer, summary);
}

}  // namespace rubicon::tuples
