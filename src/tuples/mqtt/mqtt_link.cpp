#include "tuples/mqtt/mqtt_link.h"

#include <fmt/format.h>

#include <algorithm>

#include "tuples/peer_policy.h"
#include "tuples/refusals.h"

namespace rubicon::tuples::mqtt {

namespace {

/// Bytes that may wait for one component; beyond them publish() and remote_set() refuse.
constexpr std::size_t kMaxWaiting = std::size_t{512} * 1024, kMaxSetsWaiting = std::size_t{32} << 20;
constexpr Duration kSeldomMoved = std::chrono::milliseconds(200);
/// Components that are remembered after they went, because their requests may arrive again.
constexpr std::size_t kMaxGone = 1000;

std::unique_ptr<PeerPolicy> policy_of(OwnerId self, const std::string& host, const SpaceOptions& options,
                                      base::LimitedLog& log) {
  if (options.judge) return std::make_unique<MemberPolicy>(self, options.judge);
  return std::make_unique<DeclaredHostPolicy>(self, host, options.trust_broker, log.unlimited());
}

Error too_large_for_broker(std::string_view key, std::size_t size, std::size_t largest) {
  const auto limit = largest == SIZE_MAX ? std::string("that is more than the broker takes")
                                         : fmt::format("the broker takes at most {}", largest);
  return {ErrorCode::kOutOfRange, fmt::format("{} with its value has {} bytes, {}", key, size, limit)};
}

/// Nobody here deals with it any longer. One that is there is looked for until it goes: who reads it again and again
/// does not ask the broker each time.
void drop(Search& search, const Presence& presence, OwnerId id) {
  search.drop(id);
  if (!presence.reached(id)) search.forget(id);
}

bool may_meet(const SubscriptionSpec& spec, OwnerId owner) {
  return !spec.pattern.owner || *spec.pattern.owner == owner;
}

}  // namespace

MqttLink::MqttLink(MqttEcology& ecology, StandIn who)
    : ecology_(ecology), who_(std::move(who)), policy_(policy_of(who_.id, who_.host, ecology.options_, ecology.log_)) {
  ecology_.links_.put(who_.id, *this);
}

MqttLink::~MqttLink() {
  detach();
  ecology_.links_.erase(who_.id);
}

void MqttLink::attach(LinkListener& listener, std::uint64_t incarnation) {
  detach();
  listener_ = &listener;
  incarnation_ = std::max(incarnation, incarnation_ + 1);
  ecology_.search_.keep(who_.id);  // who else may have it
  ecology_.show(*this);
  lifetime_.post(ecology_.scheduler_, [this, start = incarnation_] {
    if (attached() && incarnation_ == start) introduce();
  });
}

void MqttLink::detach() {
  if (!listener_) return;
  flush();
  listener_ = nullptr;
  introduced_ = displaced_ = false;
  for (const auto& [number, spec] : std::exchange(subscriptions_, {})) {
    if (spec.pattern.owner) drop(ecology_.search_, ecology_.presence_, *spec.pattern.owner);
  }
  for (const auto id : peers()) policy_->peer_down(id);
  peers_.clear();
  held_bytes_ = 0;
  ecology_.hide(*this);
  drop(ecology_.search_, ecology_.presence_, who_.id);
}

/// Reports those that are present already.
void MqttLink::introduce() {
  introduced_ = true;
  const auto alive = lifetime_.watch();
  for (const auto id : ecology_.presence_.all()) {
    review(id, PeerEvent::kLost);
    if (alive.ended() || !attached()) return;
  }
}

// -- peers

PeerIdentity MqttLink::identity_of(OwnerId id, const Reached& reached) const {
  PeerIdentity identity{id, reached.shown.incarnation, reached.shown.host, ecology_.vouched_member(reached.line.user)};
  identity.own_process = ecology_.is_own(id, reached.shown.incarnation);
  return identity;
}

void MqttLink::review(OwnerId id, PeerEvent how) {
  if (!attached() || !introduced_ || id == who_.id) return;
  const auto found = ecology_.presence_.reached(id);
  auto* peer = find_up(id);
  const bool same = found && peer && peer->at->line.user == found->line.user &&
                    peer->identity.incarnation == found->shown.incarnation;
  const auto alive = lifetime_.watch();
  if (peer && !same) peer_down(id, how);
  if (alive.ended() || !attached() || !found) return;
  if (!same) return peer_up(id, found);
  const auto before = std::exchange(peer->at, found);
  if (before->line != found->line) moved(*peer);
  if (before->shown.summary != found->shown.summary) listener_->on_summary(id, found->shown.summary);
}

/// To another connection. A component that moves again and again does not get unacknowledged frames each time.
void MqttLink::moved(Peer& peer) {
  const auto time = ecology_.scheduler_.now();
  if (time - std::exchange(peer.moved, time) > kSeldomMoved && peer.channel) peer.channel->reconnected();
}

void MqttLink::peer_up(OwnerId id, const std::shared_ptr<const Reached>& reached) {
  const auto identity = identity_of(id, *reached);
  if (const auto may = policy_->may_join(identity); !may)
    return void(ecology_.log_.warning(fmt::format("refused {}", number(id)), may.error().text + ": ignored"));
  auto& peer = peers_[id];
  if (peer.identity.incarnation != identity.incarnation) peer = {};
  peer.identity = identity;
  peer.at = reached;
  if (peer.dealt) channel(peer).add_times(false);  // it may not have noticed, and has to subscribe again
  policy_->peer_up(as_judged(identity));
  send_interests(peer);
  const auto alive = lifetime_.watch();
  listener_->on_peer(identity, PeerEvent::kUp);
  if (!alive.ended() && attached() && !reached->shown.summary.empty() && find_up(id))
    listener_->on_summary(id, reached->shown.summary);
}

/// Every client of the broker may claim to be of this host; without a judge that gives it no rights.
PeerIdentity MqttLink::as_judged(PeerIdentity identity) const {
  if (!ecology_.options_.judge && !identity.own_process) identity.host = "broker:" + identity.host;
  return identity;
}

/// Whenever an owner is met again it is asked again, and sends snapshots.
void MqttLink::send_interests(Peer& peer) {
  for (const auto& [number, spec] : subscriptions_) send_interest(peer, spec);
  ecology_.flush_soon_.request();
}

/// Values will come: of many owners at once, so that from now on each may send little.
void MqttLink::send_interest(Peer& peer, const SubscriptionSpec& spec) {
  if (!may_meet(spec, peer.identity.id)) return;
  distant::FrameWriter entry;
  entry.add_subscription(spec);
  channel(peer).add(entry.take());
  ecology_.heard_[peer.identity.id] = ecology_.scheduler_.now();
}

/// Only few of the known components deal with this one.
Channel& MqttLink::channel(Peer& peer) {
  if (!peer.channel) {
    const Channel::Ends ends{who_.id, peer.identity.id, incarnation_, peer.identity.incarnation};
    peer.channel =
        std::make_unique<Channel>(ecology_.scheduler_, ends, ++ecology_.streams_, channel_calls(peer.identity.id));
    peer.dealt = true;
  }
  return *peer.channel;
}

Channel::Callbacks MqttLink::channel_calls(OwnerId id) {
  Channel::Callbacks calls;
  calls.send = [this](const FrameHead& head, ByteView entries) { return ecology_.send(head, entries); };
  calls.may_swallow = [this](std::size_t size) { return ecology_.may_swallow(size); };
  calls.too_large = [this, id](ByteView entries) { give_up(id, entries); };
  calls.received = [this, id](ByteView entries) { received(id, entries); };
  calls.met_again = [this, id] {
    if (auto* again = find_up(id)) send_interests(*again);
  };
  calls.credit = [this] { return ecology_.credit(); };
  calls.since_boot = ecology_.since_boot_;
  calls.losses = &ecology_.counters_.losses;
  return calls;
}

void MqttLink::peer_down(OwnerId id, PeerEvent how) {
  auto& peer = peers_.at(id);
  peer.at.reset();
  peer.held.clear();
  held_bytes_ -= std::exchange(peer.held_bytes, 0);
  // This call may come from one of its own calls.
  ecology_.scheduler_.post([channel = std::shared_ptr(std::move(peer.channel))] {});
  const auto alive = lifetime_.watch();
  listener_->on_peer(peer.identity, how);
  if (alive.ended()) return;
  policy_->peer_down(id);
  forget_gone();
}

void MqttLink::forget_gone() {
  if (peers_.size() <= kMaxGone) return;
  const auto gone = std::count_if(peers_.begin(), peers_.end(), [](const auto& one) { return !one.second.at; });
  if (static_cast<std::size_t>(gone) > kMaxGone) std::erase_if(peers_, [](const auto& one) { return !one.second.at; });
}

MqttLink::Peer* MqttLink::find_up(OwnerId id) {
  const auto found = peers_.find(id);
  return found == peers_.end() || !found->second.at ? nullptr : &found->second;
}

/// All others are not waited for while the broker is away, as long as nobody knows when it is back.
bool MqttLink::seeks(std::optional<OwnerId> id) {
  if (id ? find_up(*id) != nullptr : !ecology_.trouble().empty()) return false;
  return !introduced_ || ecology_.seeks(id);
}

std::vector<OwnerId> MqttLink::silent(Duration patience) const {
  std::vector<OwnerId> all;
  const auto now = ecology_.scheduler_.now();
  for (const auto& [id, peer] : peers_) {
    const auto since = peer.channel ? peer.channel->unanswered_since() : std::nullopt;
    if (since && now - *since > patience) all.push_back(id);
  }
  return all;
}

std::vector<OwnerId> MqttLink::peers() const {
  std::vector<OwnerId> all;
  for (const auto& [id, peer] : peers_) {
    if (peer.at) all.push_back(id);
  }
  return all;
}

void MqttLink::displace() {
  if (std::exchange(displaced_, true)) return;
  lifetime_.post(ecology_.scheduler_, [this, call = who_.displaced] {
    if (attached() && call) call();
  });
}

// -- what is sent

void MqttLink::flush() {
  for (auto& [id, peer] : peers_) {
    if (peer.channel) peer.channel->flush();
  }
}

std::size_t MqttLink::channels() const {
  const auto has = [](const auto& one) { return one.second.channel != nullptr; };
  return static_cast<std::size_t>(std::count_if(peers_.begin(), peers_.end(), has));
}

void MqttLink::reconnected() {
  for (auto& [id, peer] : peers_) {
    if (peer.channel) peer.channel->reconnected();
  }
}

bool MqttLink::publish(OwnerId subscriber, std::span<const Change> changes) {
  auto* peer = find_up(subscriber);
  if (!peer) return true;  // no receiver: dropped
  auto& to = channel(*peer);
  if (to.waiting() > kMaxWaiting) return false;
  distant::FrameWriter entries;
  for (const auto& change : changes) {
    if (text_size(change) > ecology_.largest_) {
      if (const auto* set = std::get_if<TupleSet>(&change)) exceeds(subscriber, set->tuple.key, text_size(change));
      continue;
    }
    if (entries.size() > 0 && entries.size() + text_size(change) > Channel::kFrameBytes / 2) to.add(entries.take());
    entries.add(change);
  }
  if (entries.size() > 0) to.add(entries.take());
  ecology_.flush_soon_.request();
  return true;
}

void MqttLink::subscribe(const SubscriptionSpec& spec) {
  // Also an owner that is present: it may leave and come back.
  spec.pattern.owner ? ecology_.search_.keep(*spec.pattern.owner) : ecology_.search_.all();
  const auto [known, is_new] = subscriptions_.try_emplace(spec.id, spec);
  if (!is_new) {
    const auto former = std::exchange(known->second, spec).pattern.owner;
    if (former) drop(ecology_.search_, ecology_.presence_, *former);
  }
  for (auto& [id, peer] : peers_) {
    if (peer.at) send_interest(peer, spec);
  }
  ecology_.flush_soon_.request();
}

void MqttLink::unsubscribe(std::uint32_t id) {
  const auto found = subscriptions_.find(id);
  if (found == subscriptions_.end()) return;
  for (auto& [owner, peer] : peers_) {
    if (!peer.channel || !may_meet(found->second, owner)) continue;
    distant::FrameWriter entry;
    entry.add_unsubscription(id);
    peer.channel->add(entry.take());
  }
  if (found->second.pattern.owner) drop(ecology_.search_, ecology_.presence_, *found->second.pattern.owner);
  subscriptions_.erase(found);
  ecology_.flush_soon_.request();
}

Result<void> MqttLink::remote_set(const RemoteSet& set) {
  auto* peer = find_up(set.owner);
  if (!peer) return fail(no_component(set.owner));
  auto& to = channel(*peer);
  if (to.waiting() > kMaxSetsWaiting) return fail(takes_no_requests(set.owner));
  if (size_of(set) > ecology_.largest_) return fail(too_large_for_broker(set.key, size_of(set), ecology_.largest_));
  to.add(set);
  ecology_.flush_soon_.request();
  return {};
}

void MqttLink::exceeds(OwnerId peer, std::string_view key, std::size_t size) {
  ++ecology_.counters_.too_large;
  ecology_.log_.warning(fmt::format("too large {}", key),
                        fmt::format("component {} does not get it: {}", number(peer),
                                    too_large_for_broker(key, size, ecology_.largest_).text));
}

void MqttLink::too_large(OwnerId id, std::uint64_t stream, std::uint64_t number) {
  if (auto* peer = find_up(id); peer && peer->channel) peer->channel->too_large(stream, number);
}

/// Reports an entry that no frame can carry, also to the component that asked for it.
void MqttLink::give_up(OwnerId id, ByteView entries) {
  struct Finder final : distant::FrameReader {
    void on_changes(std::span<const Change> changes) override {
      for (const auto& change : changes) {
        if (const auto* one = std::get_if<TupleSet>(&change)) key = one->tuple.key;
      }
    }
    void on_set(RemoteSet&& one) override { set = std::move(one); }
    std::string key;
    std::optional<RemoteSet> set;
  } found;
  std::ignore = distant::read_frame(entries, who_.id, id, found);
  exceeds(id, found.set ? found.set->key : found.key, entries.size());
  if (!found.set) return;
  const auto why = too_large_for_broker(found.set->key, entries.size(), ecology_.largest_);
  lifetime_.post(ecology_.scheduler_,
                 [this, id, reply = Reply{who_.id, found.set->request, Verdict::kRefused, why.code, why.text}] {
                   if (listener_) listener_->on_reply(id, reply);
                 });
}

/// Replies beyond the bound are dropped: a component that sends many requests and reads no replies loses them.
void MqttLink::reply(const Reply& reply) {
  auto* peer = find_up(reply.to);
  if (!peer) return;
  auto& to = channel(*peer);
  if (to.waiting() > kMaxSetsWaiting) return void(ecology_.log_.warning("replies", unread_replies(reply.to)));
  distant::FrameWriter entry;
  entry.add(reply);
  to.add(entry.take());
  ecology_.flush_soon_.request();
}

void MqttLink::describe(std::string summary) {
  if (summary == summary_) return;
  summary_ = std::move(summary);
  if (attached()) ecology_.show(*this);
}

void MqttLink::each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const {
  visit("mqtt-reconnects", ecology_.counters().reconnects);
  visit("mqtt-foreign-messages", ecology_.counters().foreign);
  visit("mqtt-too-large", ecology_.counters().too_large);
  visit("mqtt-frames-again", ecology_.counters().losses.again);
  visit("mqtt-gaps", ecology_.counters().losses.gaps);
  visit("mqtt-refused-documents", ecology_.documents().refused);
  visit("mqtt-old-documents", ecology_.documents().old);
}

}  // namespace rubicon::tuples::mqtt
