#include "tuples/mqtt/mqtt_link.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "tuples/host_policy.h"
#include "tuples/member_policy.h"

namespace rubicon::tuples::mqtt {

namespace {

/// Bytes that may wait for one component; beyond them publish() and remote_set() refuse.
constexpr std::size_t kMaxWaiting = std::size_t{512} * 1024, kMaxSetsWaiting = std::size_t{32} << 20;
constexpr std::size_t kMaxHeld = std::size_t{32} << 20;  ///< bytes of requests whose age is not known yet
constexpr Duration kAskAgain = std::chrono::seconds(1);
/// Components that are remembered after they went, because their requests may arrive again.
constexpr std::size_t kMaxGone = 1000;
/// Ids from here on are free: an id below is that of an island.
constexpr std::uint32_t kFirstFreeId = 65536;

std::unique_ptr<PeerPolicy> policy_of(OwnerId self, const std::string& host, const SpaceOptions& options,
                                      base::LimitedLog& log) {
  if (options.judge) return std::make_unique<MemberPolicy>(self, options.judge);
  return std::make_unique<HostPolicy>(self, host, options.trust_broker, log.unlimited());
}

}  // namespace

/// The user that the broker vouches for.
std::shared_ptr<const Member> member_of(const SpaceOptions& options, const std::string& user) {
  if (options.member_of) return options.member_of(user);
  if (user == kAnonymous) return nullptr;
  auto member = std::make_shared<Member>();
  member->name = user;
  member->ids.push_back({kFirstFreeId, 0xffffffff});
  constexpr std::string_view kIsland = "island-";
  if (!user.starts_with(kIsland)) return member;
  const auto id = base::parse_number<std::uint32_t>(user.substr(kIsland.size()));
  if (id && *id < kFirstFreeId) member->ids.push_back({*id, *id});
  return member;
}

namespace {

std::size_t size_of(const RemoteSet& set) {
  return sizeof(RemoteSet) + 64 + set.key.size() + set.value.size() + set.media_type.size();
}

bool may_meet(const SubscriptionSpec& spec, OwnerId owner) {
  return !spec.pattern.owner || *spec.pattern.owner == owner;
}

}  // namespace

MqttLink::MqttLink(MqttEcology& ecology, StandIn who)
    : ecology_(ecology), who_(std::move(who)), policy_(policy_of(who_.id, who_.host, ecology.options_, ecology.log_)) {
  ecology_.links_[who_.id] = this;
}

MqttLink::~MqttLink() {
  detach();
  ecology_.links_.erase(who_.id);
}

void MqttLink::attach(LinkListener& listener, std::uint64_t incarnation) {
  detach();
  listener_ = &listener;
  incarnation_ = std::max(incarnation, incarnation_ + 1);
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
  subscriptions_.clear();
  for (const auto& [id, peer] : peers_) {
    if (peer.up) policy_->peer_down(id);
  }
  peers_.clear();
  ecology_.hide(*this);
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
  PeerIdentity identity{id, reached.shown.incarnation, reached.shown.host,
                        member_of(ecology_.options_, reached.line.user)};
  identity.own_process = ecology_.is_own(id, reached.shown.incarnation);
  return identity;
}

void MqttLink::review(OwnerId id, PeerEvent how) {
  if (!attached() || !introduced_ || id == who_.id) return;
  const auto* found = ecology_.presence_.reached(id);
  const auto known = peers_.find(id);
  const bool was_up = known != peers_.end() && known->second.up;
  const bool same = found && was_up && known->second.user == found->line.user &&
                    known->second.identity.incarnation == found->shown.incarnation;
  const auto alive = lifetime_.watch();
  const auto now = found ? std::optional(*found) : std::nullopt;
  if (was_up && !same) peer_down(id, how);
  if (alive.ended() || !attached() || !now) return;
  if (!same) return peer_up(id, *now);
  auto& peer = known->second;
  if (peer.summary != now->shown.summary) {
    peer.summary = now->shown.summary;
    listener_->on_summary(id, peer.summary);
  }
}

void MqttLink::peer_up(OwnerId id, const Reached& reached) {
  const auto identity = identity_of(id, reached);
  if (const auto may = policy_->may_join(identity); !may)
    return void(ecology_.log_.warning(fmt::format("refused {}", number(id)), may.error().text + ": ignored"));
  auto& peer = peers_[id];
  peer.identity = identity;
  peer.user = reached.line.user;
  peer.up = true;
  peer.summary = reached.shown.summary;
  if (std::exchange(peer.requests_of, identity.incarnation) != identity.incarnation) peer.last_request = 0;
  open_channel(peer);
  policy_->peer_up(as_judged(identity));
  send_interests(peer);
  const auto alive = lifetime_.watch();
  const auto summary = peer.summary;
  listener_->on_peer(identity, PeerEvent::kUp);
  if (!alive.ended() && attached() && !summary.empty() && find_up(id)) listener_->on_summary(id, summary);
}

/// Whoever reaches the broker may say to be of this host: without a judge that opens nothing.
PeerIdentity MqttLink::as_judged(PeerIdentity identity) const {
  if (!ecology_.options_.judge && !identity.own_process) identity.host = "broker:" + identity.host;
  return identity;
}

/// Whenever an owner is met again it is asked again, and sends snapshots.
void MqttLink::send_interests(Peer& peer) {
  for (const auto& [number, spec] : subscriptions_) {
    if (!may_meet(spec, peer.identity.id)) continue;
    distant::FrameWriter entry;
    entry.add_subscription(spec);
    peer.channel->add(entry.take());
  }
  ecology_.flush_soon_.request();
}

void MqttLink::open_channel(Peer& peer) {
  const auto id = peer.identity.id;
  Channel::Calls calls;
  calls.send = [this](const FrameHead& head, ByteView entries) { return ecology_.send(head, entries); };
  calls.received = [this, id](ByteView entries) { received(id, entries); };
  calls.met_again = [this, id] {
    if (auto* again = find_up(id)) send_interests(*again);
  };
  calls.credit = [this] { return ecology_.credit(); };
  calls.since_boot = ecology_.since_boot_;
  peer.channel = std::make_unique<Channel>(ecology_.scheduler_,
                                           Channel::Ends{who_.id, id, incarnation_, peer.identity.incarnation},
                                           ++ecology_.streams_, std::move(calls));
}

void MqttLink::peer_down(OwnerId id, PeerEvent how) {
  auto& peer = peers_.at(id);
  peer.up = false;
  peer.held.clear();
  peer.held_bytes = 0;
  // It may be one of its calls that brought this.
  ecology_.scheduler_.post([channel = std::shared_ptr(std::move(peer.channel))] {});
  const auto alive = lifetime_.watch();
  listener_->on_peer(peer.identity, how);
  if (alive.ended()) return;
  policy_->peer_down(id);
  forget_gone();
}

void MqttLink::forget_gone() {
  if (peers_.size() <= kMaxGone) return;
  const auto gone = std::count_if(peers_.begin(), peers_.end(), [](const auto& one) { return !one.second.up; });
  if (static_cast<std::size_t>(gone) > kMaxGone) std::erase_if(peers_, [](const auto& one) { return !one.second.up; });
}

MqttLink::Peer* MqttLink::find_up(OwnerId id) {
  const auto found = peers_.find(id);
  return found == peers_.end() || !found->second.up ? nullptr : &found->second;
}

std::vector<OwnerId> MqttLink::silent(Duration patience) const {
  std::vector<OwnerId> all;
  const auto now = ecology_.scheduler_.now();
  for (const auto& [id, peer] : peers_) {
    const auto since = peer.up ? peer.channel->unanswered_since() : std::nullopt;
    if (since && now - *since > patience) all.push_back(id);
  }
  return all;
}

std::vector<OwnerId> MqttLink::peers() const {
  std::vector<OwnerId> all;
  for (const auto& [id, peer] : peers_) {
    if (peer.up) all.push_back(id);
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
    if (peer.up) peer.channel->flush();
  }
}

void MqttLink::reconnected() {
  for (auto& [id, peer] : peers_) {
    if (peer.up) peer.channel->reconnected();
  }
}

bool MqttLink::publish(OwnerId subscriber, std::span<const Change> changes) {
  auto* peer = find_up(subscriber);
  if (!peer) return true;  // no receiver: dropped
  if (peer->channel->waiting() > kMaxWaiting) return false;
  distant::FrameWriter entries;
  for (const auto& change : changes) {
    if (entries.size() > 0 && entries.size() + text_size(change) > Channel::kFrameBytes / 2)
      peer->channel->add(entries.take());
    entries.add(change);
  }
  if (entries.size() > 0) peer->channel->add(entries.take());
  ecology_.flush_soon_.request();
  return true;
}

void MqttLink::subscribe(const SubscriptionSpec& spec) {
  subscriptions_.insert_or_assign(spec.id, spec);
  for (auto& [id, peer] : peers_) {
    if (!peer.up || !may_meet(spec, id)) continue;
    distant::FrameWriter entry;
    entry.add_subscription(spec);
    peer.channel->add(entry.take());
  }
  ecology_.flush_soon_.request();
}

void MqttLink::unsubscribe(std::uint32_t id) {
  const auto found = subscriptions_.find(id);
  if (found == subscriptions_.end()) return;
  for (auto& [owner, peer] : peers_) {
    if (!peer.up || !may_meet(found->second, owner)) continue;
    distant::FrameWriter entry;
    entry.add_unsubscription(id);
    peer.channel->add(entry.take());
  }
  subscriptions_.erase(found);
  ecology_.flush_soon_.request();
}

Result<void> MqttLink::remote_set(const RemoteSet& set) {
  auto* peer = find_up(set.owner);
  if (!peer) return fail(ErrorCode::kNotFound, fmt::format("no component {} is present", number(set.owner)));
  if (peer->channel->waiting() > kMaxSetsWaiting)
    return fail(ErrorCode::kBusy,
                fmt::format("component {} does not accept requests at the moment", number(set.owner)));
  peer->channel->add(set);
  ecology_.flush_soon_.request();
  return {};
}

/// Replies beyond the bound are dropped: a component that sends many requests and reads no replies loses them.
void MqttLink::reply(const Reply& reply) {
  auto* peer = find_up(reply.to);
  if (!peer) return;
  if (peer->channel->waiting() > kMaxSetsWaiting)
    return void(ecology_.log_.warning(
        "replies", fmt::format("component {} does not read its replies: some are dropped", number(reply.to))));
  distant::FrameWriter entry;
  entry.add(reply);
  peer->channel->add(entry.take());
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
}

// -- what is received

void MqttLink::arrived(const FrameHead& head, ByteView entries) {
  if (auto* peer = find_up(head.source); peer && peer->identity.incarnation == head.source_incarnation)
    peer->channel->arrived(head, entries);
}

void MqttLink::received(OwnerId id, ByteView entries) {
  if (!find_up(id)) return;
  reading_from_ = id;
  reading_sent_.reset();
  if (auto read = distant::read_frame(entries, id, who_.id, *this); !read)
    ecology_.log_.warning(fmt::format("frame {}", number(id)), read.error().text);
}

void MqttLink::on_changes(std::span<const Change> changes) {
  if (find_up(reading_from_) && listener_) listener_->on_changes(reading_from_, changes);
}

void MqttLink::on_reply(Reply&& reply) {
  if (listener_ && !listener_->on_reply(reading_from_, reply))
    ecology_.log_.warning(
        fmt::format("replies of {}", number(reading_from_)),
        fmt::format("component {} answered a request that it was not asked: ignored", number(reading_from_)));
}

void MqttLink::on_subscription(SubscriptionSpec&& spec) {
  if (find_up(reading_from_) && listener_) listener_->on_subscribe(reading_from_, spec);
}

void MqttLink::on_unsubscription(std::uint32_t id) {
  if (find_up(reading_from_) && listener_) listener_->on_unsubscribe(reading_from_, id);
}

// -- requests, which may be late

void MqttLink::on_times(const distant::FrameTimes& times) {
  auto* peer = find_up(reading_from_);
  if (!peer) return;
  reading_sent_ = times.sent;
  peer->channel->ages().arrived(times, ecology_.since_boot_());
  if (times.asks) {
    peer->channel->add_times(false);
    ecology_.flush_soon_.request();
  }
  if (times.echo && !peer->held.empty()) take_held(reading_from_);
}

void MqttLink::on_set(RemoteSet&& set) {
  auto* peer = find_up(reading_from_);
  if (!listener_ || !peer) return;
  const bool waits = !peer->held.empty() || (set.time_to_live > Duration(0) && reading_sent_ &&
                                             !peer->channel->ages().age(*reading_sent_, ecology_.since_boot_()));
  if (!waits) return take_set(*peer, std::move(set), reading_sent_);
  const auto size = size_of(set);
  if (peer->held_bytes + size > kMaxHeld)
    return reply({set.from, set.request, Verdict::kRefused, ErrorCode::kBusy,
                  "too many requests wait until this process knows whether they may be carried out"});
  if (peer->held.empty()) peer->channel->add_times(true), ecology_.flush_soon_.request();
  peer->held_bytes += size;
  peer->held.push_back({std::move(set), reading_sent_.value_or(Duration(0)), ecology_.scheduler_.now()});
  if (!held_timer_.pending())
    held_timer_ = ecology_.scheduler_.after(kAskAgain, [this] {
      std::vector<OwnerId> ids;
      for (const auto& [id, one] : peers_) {
        if (!one.held.empty()) ids.push_back(id);
      }
      for (const auto id : ids) take_held(id);
    });
}

/// Exactly zero remains: a negative time, because zero means that none was given.
void MqttLink::take_set(Peer& peer, RemoteSet&& set, std::optional<Duration> sent) {
  if (set.request <= peer.last_request) return;  // sent again after it was acknowledged to nobody
  peer.last_request = set.request;
  if (set.time_to_live > Duration(0)) {
    const auto age = sent ? peer.channel->ages().age(*sent, ecology_.since_boot_()) : std::nullopt;
    const auto left = age ? set.time_to_live - *age : Duration(0);
    set.time_to_live = left > Duration(0) ? left : Duration(-1);
  }
  listener_->on_remote_set(set);
}

/// Those whose age is known, or whose time is over by the own clock, in order.
void MqttLink::take_held(OwnerId id) {
  const auto before = std::exchange(reading_from_, id);
  for (auto* peer = find_up(id); peer && listener_ && !peer->held.empty(); peer = find_up(id)) {
    auto& first = peer->held.front();
    const bool known = peer->channel->ages().age(first.sent, ecology_.since_boot_()).has_value();
    const auto lives = first.set.time_to_live;
    if (!known && lives > Duration(0) && ecology_.scheduler_.now() - first.since < lives) break;
    auto one = std::move(first);
    peer->held_bytes -= size_of(one.set);
    peer->held.pop_front();
    take_set(*peer, std::move(one.set), one.sent);
  }
  reading_from_ = before;
  auto* peer = find_up(id);
  if (!peer || peer->held.empty() || held_timer_.pending()) return;
  peer->channel->add_times(true);
  ecology_.flush_soon_.request();
  held_timer_ = ecology_.scheduler_.after(kAskAgain, [this, id] { take_held(id); });
}

}  // namespace rubicon::tuples::mqtt
