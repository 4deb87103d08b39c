#include "tuples/dds/presences.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "wire.h"  // made from wire.idl

namespace rubicon::tuples::dds {

namespace {

constexpr std::size_t kMaxPeers = 10'000;
/// Components remembered after they went down, because frames of them may still arrive.
constexpr std::size_t kMaxGone = 100;
constexpr std::size_t kMaxHostLength = 64;

std::string text_of(const char* text, std::size_t most) {
  return text ? std::string(text).substr(0, most) : std::string();
}

}  // namespace

Presences::Arrived Presences::take() {
  Arrived arrived;
  const auto count = dds::take<rubicon_wire_Presence>(
      entities_.presence_reader(), kSamples, [&](const auto& sample, const auto& info) {
        entities_.presence_quota().taken(info.publication_handle, info.instance_handle);
        News one;
        one.who = {OwnerId(sample.id), sample.incarnation};
        one.start.publication = info.publication_handle;
        one.there = info.instance_state == DDS_IST_ALIVE;
        one.left = info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED;
        if (one.there) {
          const auto* writer =
              info.valid_data ? writers_.find(entities_.presence_reader(), info.publication_handle) : nullptr;
          if (!writer) return;
          one.version = sample.version;
          one.start.participant = writer->participant;
          one.start.host = text_of(sample.host, kMaxHostLength);
          one.start.summary = text_of(sample.summary, kMaxSummary + 1);
          if (one.start.summary.size() > kMaxSummary) one.start.summary.clear();
        } else {
          note_end(info.publication_handle, info.instance_handle);
          arrived.some_ended = true;
        }
        arrived.news.push_back(std::move(one));
      });
  arrived.more = count >= kSamples;
  return arrived;
}

void Presences::note_end(InstanceQuota::Handle publication, InstanceQuota::Handle instance) {
  entities_.presence_quota().ended(publication, instance);
  if (!ended_.add(entities_.presence_reader(), instance)) shared_.overrun();
}

bool Presences::apply(const std::vector<News>& news) {
  for (const auto& one : news) {
    if (own_.listener && admit(one)) on_presence(one);
  }
  const bool some_gone = own_.listener && end_unmatched();
  drop_gone();
  return some_gone;
}

bool Presences::expects() const {
  if (entities_.presence_reader() == 0) return false;
  const auto there = matched_writers({entities_.presence_reader()});
  return std::any_of(there.begin(), there.end(), [this](auto publication) { return !writers_.knows(publication); });
}

const Peer* Presences::find_up(OwnerId id) const {
  const auto found = peers_.find(id);
  return found == peers_.end() || !found->second.is_up() ? nullptr : &found->second;
}

std::vector<OwnerId> Presences::up() const {
  std::vector<OwnerId> all;
  for (const auto& [id, peer] : peers_) {
    if (peer.is_up()) all.push_back(id);
  }
  return all;
}

std::set<Participant> Presences::participants_up() const {
  std::set<Participant> all;
  for (const auto& [id, peer] : peers_) {
    if (peer.is_up()) all.insert(peer.participant);
  }
  return all;
}

/// DDS lets each writer end an instance: of a start that is known only the publications that showed it count.
bool Presences::may_end(const News& news) const {
  const auto peer = peers_.find(news.who.first);
  if (peer == peers_.end()) return true;
  const auto start = peer->second.alive.find(news.who.second);
  if (start == peer->second.alive.end() || start->second.publication == news.start.publication) return true;
  return start->second.heir && start->second.heir->publication == news.start.publication;
}

/// Notes the start, logs why its component is refused, and bans the writer of a banned participant. False: ignored.
bool Presences::admit(const News& news) {
  const auto [id, incarnation] = news.who;
  if (news.there && participants_.is_banned(news.start.participant)) {
    entities_.presence_quota().ban(news.start.publication);
    return false;
  }
  if (!news.there && !may_end(news)) return false;
  if (news.who != Participants::Start(own_.id, own_.incarnation))
    shared_.starts->note({id, incarnation, news.version, news.there, news.start.summary, news.start.publication});
  if (!news.there) return true;
  if (news.version != kProtocolVersion) {
    log_.warning(
        fmt::format("version {}", number(id)),
        fmt::format("component {} has version {} of the protocol, this program version {}: ignored{}", number(id),
                    news.version, kProtocolVersion,
                    news.version > kProtocolVersion ? "; it is of a newer release, install that here too" : ""));
    return false;
  }
  auto may = DeclaredHostPolicy::check_start(id, incarnation);
  if (may) may = policy_.may_join(identity_of(id, incarnation, news.start));
  if (!may) log_.warning(fmt::format("refused {}", number(id)), may.error().text + ": ignored");
  return may.has_value();
}

/// DDS knows no names: with rights all components on it are one member.
PeerIdentity Presences::identity_of(OwnerId id, std::uint64_t incarnation, const Peer::Start& start) const {
  static const auto kAll = std::make_shared<const Member>(Member{std::string(kLanMember)});
  PeerIdentity identity{id, incarnation, start.host, shared_.options.judge ? kAll : nullptr};
  identity.own_process = shared_.has(start.participant);
  return identity;
}

void Presences::on_presence(const News& news) {
  const auto [id, incarnation] = news.who;
  if (id == own_.id)
    return news.there ? conflicts_.seen(incarnation, news.start.participant) : conflicts_.gone(incarnation);
  if (!news.there) return on_absence(news);
  if (auto* peer = find_or_add(id); peer && own_.listener) add_start(*peer, news);
}

void Presences::add_start(Peer& peer, const News& news) {
  const auto [id, incarnation] = news.who;
  const auto& who = news.start.participant;
  const auto known = peer.alive.find(incarnation);
  if (known != peer.alive.end() && known->second.participant != who) {
    known->second.heir = std::make_shared<const Peer::Start>(news.start);
    return void(log_.warning(
        fmt::format("forged {}", number(id)),
        fmt::format("another DDS participant claims to be component {}, with the same start: ignored while the "
                    "first one is there",
                    number(id))));
  }
  if (known == peer.alive.end()) {
    if (!participants_.add(who, news.who)) return ban(who);
    for (auto other = peer.alive.begin(), next = other; other != peer.alive.end(); other = next) {
      next = std::next(other);
      if (other->second.participant == who) remove_start(id, peer, other);
    }
  }
  const auto place = known == peer.alive.end() ? ++starts_seen_ : known->second.place;
  auto heir = known == peer.alive.end() ? nullptr : known->second.heir;
  auto& start = peer.alive[incarnation] = news.start;
  start.heir = std::move(heir);
  start.place = place;
  if (peer.alive.size() > Peer::kMaxStarts) remove_start(id, peer, excess_start(peer, incarnation));
  select_incarnation(id, peer, false);
}

/// Which start to forget. The earliest stays (it is genuine unless a clock was set back), and so does the newcomer. Of
/// the others, the one that arrived last goes.
Peer::Starts::iterator Presences::excess_start(Peer& peer, std::uint64_t newcomer) {
  auto last = peer.alive.end();
  for (auto one = std::next(peer.alive.begin()); one != peer.alive.end(); ++one) {
    if (one->first == newcomer) continue;
    if (last == peer.alive.end() || one->second.place > last->second.place) last = one;
  }
  return last;
}

void Presences::remove_start(OwnerId id, Peer& peer, Peer::Starts::iterator start) {
  participants_.remove(start->second.participant, {id, start->first});
  peer.alive.erase(start);
}

void Presences::on_absence(const News& news) {
  const auto [id, incarnation] = news.who;
  const auto found = peers_.find(id);
  if (found == peers_.end()) return;
  const auto start = found->second.alive.find(incarnation);
  if (start == found->second.alive.end()) return;
  auto& heir = start->second.heir;
  if (heir && heir->publication == news.start.publication) heir.reset();
  if (start->second.publication == news.start.publication) end_start(news.who, news.left);
}

void Presences::end_start(const Participants::Start& who, bool left) {
  const auto [id, incarnation] = who;
  const auto found = peers_.find(id);
  if (found == peers_.end()) return;
  const auto start = found->second.alive.find(incarnation);
  if (start == found->second.alive.end()) return;
  const auto heir = start->second.heir;
  remove_start(id, found->second, start);
  select_incarnation(id, found->second, left);
  if (!heir || !own_.listener) return;
  if (auto* peer = find_or_add(id); peer && own_.listener)
    add_start(*peer, {who, true, false, kProtocolVersion, *heir});
}

bool Presences::is_alive(OwnerId id, std::uint64_t incarnation) const {
  const auto found = peers_.find(id);
  return found != peers_.end() && found->second.alive.contains(incarnation);
}

/// A presence lives as long as its publication is matched, whatever others do with the instance. So do the starts of
/// components that are ignored. True: some are gone.
bool Presences::end_unmatched() {
  dds_subscription_matched_status_t status;
  if (dds_get_subscription_matched_status(entities_.presence_reader(), &status) != DDS_RETCODE_OK) return false;
  const auto unmatched = status.total_count - status.current_count;
  if (std::exchange(unmatched_seen_, unmatched) == unmatched) return false;
  const auto there = matched_writers({entities_.presence_reader()});
  std::vector<News> gone;
  for (const auto& [id, peer] : peers_) {
    for (const auto& [incarnation, start] : peer.alive) {
      for (const auto* one : {&start, start.heir.get()}) {
        if (one && !there.contains(one->publication)) gone.push_back({{id, incarnation}, false, false, 0, *one});
      }
    }
  }
  for (const auto& one : gone) {
    if (!own_.listener) return false;
    on_absence(one);
  }
  shared_.starts->keep_only(
      [&](const ComponentStart& one) { return there.contains(one.publication) || is_alive(one.id, one.incarnation); });
  return own_.listener != nullptr;
}

/// Ignores the participant and all its components for as long as it is present.
void Presences::ban(const Participant& who) {
  log_.warning("banned", fmt::format("one DDS participant claims more than {} components: it is ignored",
                                     Participants::kMaxComponents));
  shut_out(who);
}

void Presences::shut_out(const Participant& who) {
  for (const auto& start : participants_.ban(who)) {
    shared_.starts->note({start.first, start.second, kProtocolVersion, false, {}});
    end_start(start, false);
  }
  notifier_.on_shut_out(who);
}

/// nullptr: too many peers.
Peer* Presences::find_or_add(OwnerId id) {
  if (const auto found = peers_.find(id); found != peers_.end()) return &found->second;
  if (peers_.size() >= kMaxPeers) evict();
  if (peers_.size() < kMaxPeers) return &peers_[id];
  log_.warning("peers", fmt::format("component {} is ignored: there are {} others already", number(id), peers_.size()));
  return nullptr;
}

/// Removes the peers that went down; if that is not enough, bans the participant with most components.
void Presences::evict() {
  forget_gone();
  if (peers_.size() < kMaxPeers) return;
  if (const auto largest = participants_.largest()) ban(*largest);
  forget_gone();
}

void Presences::forget_gone() {
  std::erase_if(peers_, [this](const auto& one) {
    const bool gone = one.second.alive.empty() && !one.second.is_up();
    if (gone) notifier_.on_forgotten(one.first);
    return gone;
  });
}

void Presences::drop_gone() {
  for (; gone_.size() > kMaxGone; gone_.pop_front()) {
    const auto found = peers_.find(gone_.front());
    if (found == peers_.end() || !found->second.alive.empty() || found->second.is_up()) continue;
    notifier_.on_forgotten(found->first);
    peers_.erase(found);
  }
}

/// Makes the latest start that is present the peer's incarnation.
void Presences::select_incarnation(OwnerId id, Peer& peer, bool left) {
  const auto wanted = peer.alive.empty() ? 0 : peer.alive.rbegin()->first;
  if (wanted == peer.incarnation) return report_summary(id, peer);
  if (peer.is_up()) peer_down(id, peer, left ? PeerEvent::kLeft : PeerEvent::kLost);
  if (wanted != 0 && own_.listener) peer_up(id, peer, wanted);
}

void Presences::report_summary(OwnerId id, Peer& peer) {
  if (!own_.listener || !peer.is_up()) return;
  const auto& summary = peer.alive.at(peer.incarnation).summary;
  if (summary == peer.summary) return;
  peer.summary = summary;
  own_.listener->on_summary(id, peer.summary);
}

void Presences::peer_up(OwnerId id, Peer& peer, std::uint64_t incarnation) {
  const auto& start = peer.alive.at(incarnation);
  const Sender sender{id, incarnation, start.participant};
  const bool again = incarnation <= peer.latest;
  peer.incarnation = incarnation;
  peer.latest = std::max(peer.latest, incarnation);
  peer.participant = start.participant;
  peer.host = start.host;
  peer.summary.clear();
  const auto identity = identity_of(id, incarnation, start);
  policy_.peer_up(identity);
  own_.listener->on_peer(identity, PeerEvent::kUp);
  if (own_.listener) report_summary(id, peer);
  if (own_.listener) notifier_.on_met(sender, again);
}

void Presences::peer_down(OwnerId id, Peer& peer, PeerEvent event) {
  const PeerIdentity identity{id, std::exchange(peer.incarnation, 0), peer.host};
  gone_.push_back(id);
  notifier_.on_lost(id);
  own_.listener->on_peer(identity, event);
  policy_.peer_down(id);
}

void Presences::forget_gone_writers() {
  if (!writers_.is_long()) return;
  const auto there =
      matched_writers({entities_.presence_reader(), entities_.interest_reader(), entities_.frame_reader()});
  participants_.keep_only(writers_.keep_only(there));
  for (auto* quota : {&entities_.presence_quota(), &entities_.interest_quota()}) quota->keep_only(there);
}

void Presences::lose_all() {
  std::vector<OwnerId> there;
  shared_.starts->keep_only([](const ComponentStart&) { return false; });
  for (auto& [id, peer] : peers_) {
    peer.alive.clear();
    if (peer.is_up()) there.push_back(id);
  }
  for (const auto id : there) {
    const auto found = peers_.find(id);
    if (own_.listener && found != peers_.end()) peer_down(id, found->second, PeerEvent::kLost);
  }
  forget_domain();
}

void Presences::clear() {
  forget_domain();
  peers_.clear();
  gone_.clear();
}

/// What DDS reported of others.
void Presences::forget_domain() {
  for (const auto& [id, peer] : peers_) {
    if (peer.is_up()) policy_.peer_down(id);
  }
  ended_.clear();
  participants_.clear();
  writers_.clear();
  unmatched_seen_ = 0;
}

}  // namespace rubicon::tuples::dds
