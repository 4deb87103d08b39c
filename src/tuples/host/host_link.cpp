#include "tuples/host/host_link.h"

#include <fmt/format.h>

#include <algorithm>

#include "tuples/peer_policy.h"
#include "tuples/refusals.h"

namespace rubicon::tuples::host {

namespace {

/// Bytes that may wait for a process; beyond them publish() and remote_set() refuse.
constexpr std::size_t kMaxWaiting = std::size_t{1} << 20, kMaxSetsWaiting = std::size_t{32} << 20;

/// The kernel keeps out users who may not enter the folder; all others may do everything.
class FolderPolicy final : public OpenPolicy {
 public:
  void peer_up(const PeerIdentity& peer) override { hosts_[peer.id] = real_host(peer.host); }
  void peer_down(OwnerId peer) override { hosts_.erase(peer); }
  std::string_view host(OwnerId peer) const override {
    const auto found = hosts_.find(peer);
    return found == hosts_.end() ? std::string_view() : found->second;
  }

 private:
  std::map<OwnerId, std::string> hosts_;
};

std::unique_ptr<PeerPolicy> policy_of(OwnerId self, const std::shared_ptr<Judge>& judge) {
  if (judge) return std::make_unique<MemberPolicy>(self, judge);
  return std::make_unique<FolderPolicy>();
}

}  // namespace

// -- of the ecology

void HostEcology::tell_all(const Record& record) {
  for (const auto& process : processes_) {
    if (process->introduced && !process->ended) process->connection.send(record);
  }
}

void HostEcology::each_listener(OwnerId peer, const std::function<void(LinkListener& to)>& call) {
  links_.each([&](HostLink& link) {
    if (auto* to = link.listener(peer)) call(*to);
  });
}

/// Whether an own component subscribes to what one of that process may have.
bool HostEcology::reads_from(const Process& process) const {
  return std::any_of(links_.all().begin(), links_.all().end(), [&](const auto& link) {
    const auto& all = link.second->subscriptions();
    return std::any_of(all.begin(), all.end(), [&](const auto& one) {
      const auto& owner = one.second.pattern.owner;
      return owner ? process.components.contains(*owner) : !process.components.empty();
    });
  });
}

// -- of the link

HostLink::HostLink(HostEcology& ecology, StandIn who, std::unique_ptr<IdLock> lock)
    : ecology_(ecology),
      who_(std::move(who)),
      lock_(std::move(lock)),
      policy_(policy_of(who_.id, ecology.options_.judge)) {
  ecology_.links_.put(who_.id, *this);
}

HostLink::~HostLink() {
  detach();
  ecology_.links_.erase(who_.id);
}

void HostLink::attach(LinkListener& listener, std::uint64_t incarnation) {
  detach();
  listener_ = &listener;
  incarnation_ = std::max(incarnation, incarnation_ + 1);
  ecology_.tell_all(shown());
  lifetime_.post(ecology_.scheduler_, [this, start = incarnation_] {
    if (attached() && incarnation_ == start) introduce();
  });
}

void HostLink::detach() {
  if (!listener_) return;
  listener_ = nullptr;
  introduced_ = displaced_ = false;
  subscriptions_.clear();
  for (const auto id : std::exchange(known_, {})) policy_->peer_down(id);
  ecology_.tell_all({Record::Type::kDown, who_.id});
}

/// Reports those that are present already.
void HostLink::introduce() {
  introduced_ = true;
  const auto all = ecology_.present_;
  const auto alive = lifetime_.watch();
  for (const auto& [id, peer] : all) {
    const auto* now = ecology_.present(id);
    if (now && now->at == peer.at) peer_up(*now);
    if (alive.ended() || !attached()) return;
  }
}

void HostLink::peer_up(const HostEcology::Present& peer) {
  const auto id = peer.who.id;
  if (!attached() || !introduced_ || id == who_.id || !known_.insert(id).second) return;
  const auto alive = lifetime_.watch();
  // Its subscriptions and its summary may change with each call.
  const auto component = peer.at->components.at(id);
  policy_->peer_up(peer.who);
  listener_->on_peer(peer.who, PeerEvent::kUp);
  const auto hearing = [&] { return alive.ended() ? nullptr : listener(id); };
  if (auto* to = hearing(); to && !component.summary.empty()) to->on_summary(id, component.summary);
  for (const auto& [number, spec] : component.interests) {
    if (auto* to = hearing()) to->on_subscribe(id, spec);
  }
}

void HostLink::peer_down(const PeerIdentity& who, PeerEvent how) {
  if (!attached() || known_.erase(who.id) == 0) return;
  const auto alive = lifetime_.watch();
  listener_->on_peer(who, how);
  if (!alive.ended()) policy_->peer_down(who.id);
}

/// Passes the entries of a frame, until the link was detached or destroyed by one of them.
struct HostLink::Delivery final : distant::FrameReader {
  Delivery(HostLink& to, OwnerId source) : link(to), from(source), alive(to.lifetime_.watch()) {}

  bool is_heard() const { return !alive.ended() && link.listener_; }
  void on_changes(std::span<const Change> changes) override {
    if (is_heard()) link.listener_->on_changes(from, changes);
  }
  /// Exactly zero remains: a negative time, because zero means that none was given.
  void on_set(RemoteSet&& set) override {
    if (!is_heard()) return;
    if (set.time_to_live > Duration(0)) {
      if (now == Duration(0)) now = link.ecology_.folder_->since_boot();
      set.time_to_live = set.time_to_live > now ? set.time_to_live - now : Duration(-1);
    }
    link.listener_->on_remote_set(set);
  }
  void on_reply(Reply&& reply) override {
    if (is_heard() && !link.listener_->on_reply(from, reply))
      link.ecology_.log_.warning(fmt::format("replies of {}", number(from)), unasked_reply(from));
  }

  HostLink& link;
  OwnerId from;
  base::Lifetime::Watch alive;
  Duration now{0};  ///< read once for all entries
};

Result<void> HostLink::deliver(OwnerId source, ByteView entries) {
  if (!listener(source)) return {};
  Delivery delivery(*this, source);
  return distant::read_frame(entries, source, who_.id, delivery);
}

HostLink::Way HostLink::way_to(OwnerId peer) const {
  const auto* present = listener(peer) ? ecology_.present(peer) : nullptr;
  return present ? Way{&present->at->connection, peer, present->who.incarnation} : Way{};
}

bool HostLink::publish(OwnerId subscriber, std::span<const Change> changes) {
  const auto way = way_to(subscriber);
  if (!way.connection) return true;  // no receiver: dropped
  if (way.connection->waiting() > kMaxWaiting) return false;
  for (const auto& change : changes) {
    if (entries_.size() > 0 && entries_.size() + text_size(change) > Connection::kFrameBytes) send(way);
    entries_.add(change);
  }
  if (entries_.size() > 0) send(way);
  return true;
}

void HostLink::send(const Way& way) {
  way.connection->send({Record::Type::kFrame, who_.id, way.peer, way.incarnation, {}, entries_.view()});
  entries_.clear();
}

void HostLink::ask(Connection& to) const {
  for (const auto& [id, spec] : subscriptions_) {
    distant::FrameWriter content;
    content.add(spec);
    to.send({Record::Type::kInterest, who_.id, {}, 0, {}, content.view()});
  }
}

void HostLink::subscribe(const SubscriptionSpec& spec) {
  subscriptions_.insert_or_assign(spec.id, spec);
  distant::FrameWriter content;
  content.add(spec);
  ecology_.tell_all({Record::Type::kInterest, who_.id, {}, 0, {}, content.view()});
}

void HostLink::unsubscribe(std::uint32_t id) {
  if (subscriptions_.erase(id) == 0) return;
  ecology_.tell_all({Record::Type::kNoInterest, who_.id, {}, id});
}

Result<void> HostLink::remote_set(const RemoteSet& set) {
  const auto way = way_to(set.owner);
  if (!way.connection) return fail(no_component(set.owner));
  if (way.connection->waiting() > kMaxSetsWaiting) return fail(takes_no_requests(set.owner));
  const auto left = set.time_to_live;
  entries_.add(set, left > Duration(0) ? left + ecology_.folder_->since_boot() : left);
  send(way);
  return {};
}

/// Replies beyond the bound are dropped: a component that sends many requests and reads no replies loses them.
void HostLink::reply(const Reply& reply) {
  const auto way = way_to(reply.to);
  if (!way.connection) return;
  if (way.connection->waiting() > kMaxSetsWaiting)
    return void(ecology_.log_.warning("replies", unread_replies(reply.to)));
  entries_.add(reply);
  send(way);
}

std::vector<OwnerId> HostLink::peers() const {
  return {known_.begin(), known_.end()};
}

void HostLink::describe(std::string summary) {
  if (summary == summary_) return;
  summary_ = std::move(summary);
  if (attached()) ecology_.tell_all({Record::Type::kSummary, who_.id, {}, 0, {}, base::as_bytes(summary_)});
}

void HostLink::displace() {
  if (std::exchange(displaced_, true)) return;
  lifetime_.post(ecology_.scheduler_, [this, call = who_.displaced] {
    if (attached() && displaced_ && call) call();
  });
}

}  // namespace rubicon::tuples::host
