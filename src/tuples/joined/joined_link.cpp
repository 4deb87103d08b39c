#include "tuples/joined/joined_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "tuples/joined/joined_ecology.h"
#include "tuples/link.h"
#include "tuples/refusals.h"

namespace rubicon::tuples::joined {

namespace {

/// Conflicts remembered, so that each is logged once.
constexpr std::size_t kMaxLogged = 1000;
/// The engine that does not prove of which host a component is: components of this host come to its folder.
constexpr const char* kUnproven = "dds";

}  // namespace

/// An engine, and the listener of its link.
class JoinedLink::Port final : public LinkListener {
 public:
  Port(JoinedLink& joined, std::size_t number, Engine engine)
      : name(std::move(engine.name)), link(std::move(engine.link)), joined_(joined), number_(number) {}

  void on_changes(OwnerId owner, std::span<const Change> changes) override {
    if (joined_.listener_) joined_.on_changes(number_, owner, changes);
  }
  void on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) override {
    if (joined_.listener_) joined_.on_subscribe(number_, subscriber, spec);
  }
  void on_unsubscribe(OwnerId subscriber, std::uint32_t id) override {
    if (joined_.listener_) joined_.on_unsubscribe(number_, subscriber, id);
  }
  void on_remote_set(const RemoteSet& set) override {
    if (joined_.listener_) joined_.on_remote_set(number_, set);
  }
  bool on_reply(OwnerId from, const Reply& reply) override {
    return !joined_.listener_ || joined_.on_reply(number_, from, reply);
  }
  void on_peer(const PeerIdentity& peer, PeerEvent event) override {
    if (joined_.listener_) joined_.on_peer(number_, peer, event);
  }
  void on_summary(OwnerId peer, std::string_view summary) override {
    if (joined_.listener_) joined_.on_summary(number_, peer, summary);
  }

  const std::string name;
  const std::unique_ptr<Link> link;

 private:
  JoinedLink& joined_;
  std::size_t number_;
};

JoinedLink::JoinedLink(OwnerId self, std::vector<Engine> engines, Scheduler& scheduler, base::LogSink& log,
                       std::string own_host)
    : self_(self),
      scheduler_(scheduler),
      log_(Log(log, "tuples"), scheduler),
      own_host_(std::move(own_host)),
      policy_([this](OwnerId peer) -> PeerPolicy* {
        if (peer == model::kNoOwner) return any_policy();
        const bool observes = peer == kLinkItself && !observers_.empty();
        auto* link = observes ? ports_[*observers_.begin()]->link.get() : link_to(peer);
        return link ? &link->policy() : nullptr;
      }) {
  for (auto& engine : engines) ports_.push_back(std::make_unique<Port>(*this, ports_.size(), std::move(engine)));
}

JoinedLink::~JoinedLink() {
  detach();
}

void JoinedLink::attach(LinkListener& listener, std::uint64_t incarnation) {
  detach();
  listener_ = &listener;
  incarnation_ = std::max(incarnation, incarnation_ + 1);
  for (const auto& port : ports_) port->link->attach(*port, incarnation_);
}

void JoinedLink::detach() {
  if (!std::exchange(listener_, nullptr)) return;
  ++attachment_;
  peers_.clear();
  subscriptions_.clear();
  arriving_.reset();
  held_.clear();
  next_held_.clear();
  observers_.clear();
  for (const auto& port : ports_) port->link->detach();
}

MetPeer* JoinedLink::find(OwnerId id) {
  const auto found = peers_.find(id);
  return found == peers_.end() ? nullptr : &found->second;
}

Meeting* JoinedLink::find(OwnerId id, std::size_t engine) {
  auto* peer = find(id);
  return peer ? peer->at(engine) : nullptr;
}

std::optional<std::size_t> JoinedLink::home_of(OwnerId id) const {
  const auto found = peers_.find(id);
  return found == peers_.end() ? std::nullopt : found->second.home();
}

/// The policy of an engine that has a judge, if there is one. An engine that knows no members has no judge.
PeerPolicy* JoinedLink::any_policy() {
  for (const auto& port : ports_) {
    auto& policy = port->link->policy();
    if (policy.judge()) return &policy;
  }
  return &ports_.front()->link->policy();
}

/// The engine that brought the request which is being decided, else the one where the component lives.
Link* JoinedLink::link_to(OwnerId id) {
  const auto engine = arriving_ && arriving_->from == id ? std::optional(arriving_->engine) : home_of(id);
  return engine ? ports_[*engine]->link.get() : nullptr;
}

bool JoinedLink::publish(OwnerId subscriber, std::span<const Change> changes) {
  if (subscriber == kLinkItself) return publish_to_observers(changes);
  auto* link = link_to(subscriber);
  return !link || link->publish(subscriber, changes);
}

void JoinedLink::subscribe(const SubscriptionSpec& spec) {
  subscriptions_[spec.id] = spec;
  for (const auto& port : ports_) port->link->subscribe(spec);
}

void JoinedLink::unsubscribe(std::uint32_t id) {
  subscriptions_.erase(id);
  for (const auto& port : ports_) port->link->unsubscribe(id);
}

Result<void> JoinedLink::remote_set(const RemoteSet& set) {
  const auto now = scheduler_.now();
  if (const auto due = search_end(set.owner); held_.has(set.owner) || due > now) {
    if (!held_.hold(set, now)) return fail(ErrorCode::kBusy, "too many remote sets wait for their owners");
    next_held_.advance_to(due);
    return {};
  }
  if (auto* link = link_to(set.owner)) return link->remote_set(set);
  return fail(no_component(set.owner));
}

void JoinedLink::reply(const Reply& reply) {
  if (auto* link = link_to(reply.to)) link->reply(reply);
}

std::vector<OwnerId> JoinedLink::peers() const {
  std::vector<OwnerId> present;
  for (const auto& [id, peer] : peers_) {
    if (peer.home()) present.push_back(id);
  }
  return present;
}

/// Asks all engines, so that each begins to search.
bool JoinedLink::seeks(std::optional<OwnerId> id) {
  if (id && home_of(*id)) return false;
  return std::count_if(ports_.begin(), ports_.end(), [id](const auto& port) { return port->link->seeks(id); }) > 0;
}

void JoinedLink::each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const {
  for (const auto& port : ports_) port->link->each_counter(visit);
}

void JoinedLink::describe(std::string summary) {
  for (const auto& port : ports_) port->link->describe(summary);
}

void JoinedLink::on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event) {
  if (who.id == self_) return;
  const auto attachment = attachment_;
  if (find(who.id, engine)) part(engine, who.id, event == PeerEvent::kUp ? PeerEvent::kLost : event);
  if (event == PeerEvent::kUp && attachment == attachment_) meet(engine, who);
}

void JoinedLink::meet(std::size_t engine, const PeerIdentity& who) {
  auto& peer = peers_.try_emplace(who.id, ports_.size()).first->second;
  const bool barred = is_barred(engine, who);
  const auto move = peer.meet(engine, who, barred);
  if (barred)
    peer.at(engine)->conflict = scheduler_.after(kContactTime, [this, id = who.id, engine] { log_barred(id, engine); });
  peer.at(engine)->since = scheduler_.now();
  if (held_.has(who.id) && search_end(who.id) == SteadyTime{}) next_held_.advance_to(scheduler_.now());
  if (!barred) watch_conflict(peer, who.id, engine);
  report(who.id, move);
}

/// Components of this host come to its folder; kernels of PEIS have no other way. A component that claims this host by
/// DDS may be anywhere.
bool JoinedLink::is_barred(std::size_t engine, const PeerIdentity& who) const {
  return !own_host_.empty() && ports_[engine]->name == kUnproven && !who.own_process &&
         real_host(who.host) == own_host_;
}

void JoinedLink::log_barred(OwnerId id, std::size_t engine) {
  const auto* peer = find(id);
  if (!peer || !peer->at(engine) || peer->home()) return;
  log_.warning(fmt::format("barred {}", number(id)),
               fmt::format("component {} says by {} that it is of this host, but did not come to the folder of this "
                           "host: ignored",
                           number(id), ports_[engine]->name));
}

void JoinedLink::part(std::size_t engine, OwnerId id, PeerEvent how) {
  const auto attachment = attachment_;
  report(id, peers_.at(id).part(engine, how));
  if (attachment == attachment_ && peers_.at(id).is_forgotten()) peers_.erase(id);
}

void JoinedLink::report(OwnerId id, const MetPeer::Move& move) {
  const auto attachment = attachment_;
  if (move.down) listener_->on_peer(*move.down, move.how);
  if (!move.up || attachment != attachment_) return;
  const auto& meeting = *find(id, *move.up);
  const auto [identity, summary, subscriptions] = std::tuple(meeting.identity, meeting.summary, meeting.subscriptions);
  listener_->on_peer(identity, PeerEvent::kUp);
  if (attachment == attachment_ && !summary.empty()) listener_->on_summary(id, summary);
  for (const auto& one : subscriptions) {
    if (attachment == attachment_) listener_->on_subscribe(id, one.second);
  }
  if (move.was_rival && attachment == attachment_) ask_again(*move.up);
}

/// While only a stand-in is met, until when the component itself is looked for; else a time that is over.
SteadyTime JoinedLink::search_end(OwnerId owner) const {
  const auto found = peers_.find(owner);
  const auto* meeting =
      found != peers_.end() && found->second.home() ? found->second.at(*found->second.home()) : nullptr;
  return meeting && is_stand_in(meeting->identity) ? meeting->since + kSearchTime : SteadyTime{};
}

/// Sends what waited to where the component lives now.
void JoinedLink::release(OwnerId owner) {
  const auto attachment = attachment_;
  for (const auto& set : held_.take(owner, scheduler_.now())) {
    if (attachment != attachment_) return;
    auto* link = link_to(owner);
    const auto sent =
        link ? link->remote_set(set) : fail(ErrorCode::kNotFound, fmt::format("component {} is lost", number(owner)));
    if (!sent)
      listener_->on_reply(owner,
                          {self_, set.request, Verdict::kRefused, sent.error().code, std::move(sent.error().text)});
  }
}

void JoinedLink::release_due() {
  const auto attachment = attachment_;
  for (const auto owner : held_.owners()) {
    if (const auto due = search_end(owner); due > scheduler_.now()) {
      next_held_.advance_to(due);
    } else {
      release(owner);
    }
    if (attachment != attachment_) return;
  }
}

/// All components of that engine send their snapshots again: an engine cannot ask one of them alone.
void JoinedLink::ask_again(std::size_t engine) {
  for (const auto& one : subscriptions_) ports_[engine]->link->subscribe(one.second);
}

void JoinedLink::watch_conflict(MetPeer& peer, OwnerId id, std::size_t engine) {
  const auto rival = peer.rival_of(engine);
  if (!rival) return;
  const auto &one = peer.at(engine)->identity, &other = peer.at(*rival)->identity;
  const auto wait = is_restart(one, other) || is_restart(other, one) ? kRestartTime : kContactTime;
  peer.at(engine)->conflict = scheduler_.after(wait, [this, id, engine] { log_conflict(id, engine); });
}

void JoinedLink::log_conflict(OwnerId id, std::size_t engine) {
  const auto* peer = find(id);
  const auto rival = peer ? peer->rival_of(engine) : std::nullopt;
  if (!rival) return;
  const auto starts = std::minmax({peer->at(engine)->identity.incarnation, peer->at(*rival)->identity.incarnation});
  if (logged_.size() >= kMaxLogged) logged_.clear();
  if (!logged_.emplace(id, starts.first, starts.second).second) return;
  const auto ignored = peer->is_resident(engine) ? *rival : engine;
  log_.error(fmt::format("conflict {}", number(id)),
             fmt::format("two components have id {}: {} and {}. The one on {} is ignored: give one of them another id",
                         number(id), described(id, engine), described(id, *rival), ports_[ignored]->name));
}

std::string JoinedLink::described(OwnerId id, std::size_t engine) const {
  const auto& host = peers_.at(id).at(engine)->identity.host;
  return fmt::format("one on {}{}{}", ports_[engine]->name, host.empty() ? "" : " on host ", host);
}

void JoinedLink::on_summary(std::size_t engine, OwnerId id, std::string_view summary) {
  auto* meeting = find(id, engine);
  if (!meeting) return;
  meeting->summary = summary;
  if (home_of(id) == engine) listener_->on_summary(id, summary);
}

/// A stream that another one replaced is dropped, up to its next Restart.
void JoinedLink::on_changes(std::size_t engine, OwnerId owner, std::span<const Change> changes) {
  auto* peer = find(owner);
  if (!peer || !peer->is_resident(engine)) return;
  const auto attachment = attachment_;
  bool counts = peer->counts(engine);
  std::size_t from = 0;
  for (std::size_t at = 0; at < changes.size(); ++at) {
    const auto* restart = std::get_if<Restart>(&changes[at]);
    if (!restart) continue;
    if (counts && at > from) listener_->on_changes(owner, changes.subspan(from, at - from));
    if (attachment != attachment_) return;
    counts = peer->begin_stream(engine, *restart);
    from = at;
  }
  if (counts && from < changes.size()) listener_->on_changes(owner, changes.subspan(from));
}

/// Those accept all.
bool JoinedLink::publish_to_observers(std::span<const Change> changes) {
  return std::all_of(observers_.begin(), observers_.end(),
                     [&](std::size_t engine) { return ports_[engine]->link->publish(kLinkItself, changes); });
}

void JoinedLink::on_subscribe(std::size_t engine, OwnerId id, const SubscriptionSpec& spec) {
  if (id == kLinkItself) {
    observers_.insert(engine);
    return listener_->on_subscribe(id, spec);
  }
  auto* meeting = find(id, engine);
  if (!meeting) return;
  auto& all = meeting->subscriptions;
  if (all.size() >= kMaxSubscriptions && !all.contains(spec.id)) {
    log_.warning(fmt::format("subscriptions {}", number(id)),
                 fmt::format("component {} has too many subscriptions: one is ignored", number(id)));
    return;
  }
  all[spec.id] = spec;
  if (home_of(id) == engine) listener_->on_subscribe(id, spec);
}

void JoinedLink::on_unsubscribe(std::size_t engine, OwnerId id, std::uint32_t subscription) {
  auto* meeting = find(id, engine);
  if (!meeting) return;
  meeting->subscriptions.erase(subscription);
  if (home_of(id) == engine) listener_->on_unsubscribe(id, subscription);
}

/// The engine that brings the request decides by its policy, and carries the reply.
void JoinedLink::on_remote_set(std::size_t engine, const RemoteSet& set) {
  const auto* peer = find(set.from);
  if (!peer || !peer->at(engine)) return;
  if (!peer->is_resident(engine)) return refuse(engine, set);
  arriving_ = {engine, set.from};
  listener_->on_remote_set(set);
  arriving_.reset();
}

/// The message comes from a rival, or its engine proves less than the engine where the component lives.
void JoinedLink::refuse(std::size_t engine, const RemoteSet& set) {
  auto& peer = peers_.at(set.from);
  const auto home = peer.home();
  const bool is_rival = !home || peer.at(engine)->identity.incarnation != peer.at(*home)->identity.incarnation;
  const auto why =
      peer.at(engine)->barred
          ? fmt::format("component {} says that it is of this host, but did not come to its folder", number(set.from))
      : is_rival ? fmt::format("another component with id {} is present", number(set.from))
                 : fmt::format("{} does not prove that it is component {}, which {} proves", ports_[engine]->name,
                               number(set.from), ports_[*home]->name);
  const Reply reply{set.from, set.request, Verdict::kRefused, ErrorCode::kDuplicate,
                    fmt::format("setting '{}': {}", set.key, why)};
  auto& link = *ports_[engine]->link;
  link.policy().answered(set, reply);
  link.reply(reply);
}

/// A reply counts only from an engine that proves as much about the owner as its home engine.
bool JoinedLink::on_reply(std::size_t engine, OwnerId from, const Reply& reply) {
  const auto* peer = find(from);
  if (peer && peer->home() && !(peer->at(engine) && peer->is_resident(engine))) return false;
  return listener_->on_reply(from, reply);
}

JoinedEcology::JoinedEcology(std::vector<Engine> engines, Scheduler& scheduler, base::LogSink& log,
                             std::string own_host)
    : engines_(std::move(engines)), own_host_(std::move(own_host)), scheduler_(scheduler), log_(log) {
  RUBICON_ASSERT(!engines_.empty() && engines_.size() <= kMaxEngines);
}

Result<std::unique_ptr<Link>> JoinedEcology::join(OwnerId id) {
  std::vector<JoinedLink::Engine> links;
  for (const auto& engine : engines_) {
    auto link = engine.ecology.join(id);
    if (!link) {
      auto error = std::move(link.error());
      error.text = fmt::format("{}: {}", engine.name, error.text);
      return fail(std::move(error));
    }
    links.push_back({engine.name, std::move(*link)});
  }
  return std::make_unique<JoinedLink>(id, std::move(links), scheduler_, log_, own_host_);
}

}  // namespace rubicon::tuples::joined
