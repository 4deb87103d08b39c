#include <fmt/format.h>

#include <algorithm>

#include "tuples/dds/dds_link.h"
#include "tuples/host_policy.h"
#include "wire.h"

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

bool DdsLink::take_presences() {
  std::vector<PresenceNews> news;
  const auto count =
      take<rubicon_wire_Presence>(presence_reader_.get(), kSamples, [&](const auto& sample, const auto& info) {
        stores_->presence_quota.taken(info.publication_handle, info.instance_handle);
        PresenceNews one;
        one.who = {OwnerId(sample.id), sample.incarnation};
        one.start.publication = info.publication_handle;
        one.there = info.instance_state == DDS_IST_ALIVE;
        one.left = info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED;
        if (one.there) {
          const auto* writer =
              info.valid_data ? writers_.find(presence_reader_.get(), info.publication_handle) : nullptr;
          if (!writer) return;
          one.version = sample.version;
          one.start.participant = writer->participant;
          one.start.host = text_of(sample.host, kMaxHostLength);
          one.start.summary = text_of(sample.summary, kMaxSummary + 1);
          if (one.start.summary.size() > kMaxSummary) one.start.summary.clear();
        } else {
          stores_->presence_quota.ended(info.publication_handle, info.instance_handle);
        }
        news.push_back(std::move(one));
      });
  // What a component sent before it left arrived before its absence, such as its last replies.
  const bool some_left = std::any_of(news.begin(), news.end(), [](const auto& one) { return !one.there; });
  if (some_left && take_frames()) signal_.raise(Signal::kFrames);
  for (const auto& one : news) {
    if (listener_ && accepts(one)) on_presence(one);
  }
  if (listener_) end_unmatched();
  drop_gone_peers();
  return count >= kSamples;
}

bool DdsLink::expects_presence() const {
  if (!presence_reader_) return false;
  const auto there = matched_writers({presence_reader_.get()});
  return std::any_of(there.begin(), there.end(), [this](auto publication) { return !writers_.knows(publication); });
}

/// DDS lets each writer end an instance: of a start that is known only the publications that showed it count.
bool DdsLink::may_end(const PresenceNews& news) const {
  const auto peer = peers_.find(news.who.first);
  if (peer == peers_.end()) return true;
  const auto start = peer->second.alive.find(news.who.second);
  if (start == peer->second.alive.end() || start->second.publication == news.start.publication) return true;
  return start->second.heir && start->second.heir->publication == news.start.publication;
}

/// Records the start; false if its component is ignored.
bool DdsLink::accepts(const PresenceNews& news) {
  const auto [id, incarnation] = news.who;
  if (news.there && participants_.is_banned(news.start.participant)) {
    stores_->presence_quota.ban(news.start.publication);
    return false;
  }
  if (!news.there && !may_end(news)) return false;
  if (news.who != Participants::Start(self_, incarnation_))
    starts_->note({id, incarnation, news.version, news.there, news.start.summary});
  if (!news.there) return true;
  if (news.version != kProtocolVersion) {
    warn(fmt::format("version {}", number(id)),
         fmt::format("component {} has version {} of the protocol, this program version {}: ignored{}", number(id),
                     news.version, kProtocolVersion,
                     news.version > kProtocolVersion ? "; it is of a newer release, install that here too" : ""));
    return false;
  }
  auto may = HostPolicy::check_start(id, incarnation);
  if (may) may = policy_->may_join(identity_of(id, incarnation, news.start));
  if (!may) warn(fmt::format("refused {}", number(id)), may.error().text + ": ignored");
  return may.has_value();
}

/// DDS knows nobody by name: with rights all that it meets is one member.
PeerIdentity DdsLink::identity_of(OwnerId id, std::uint64_t incarnation, const Peer::Start& start) const {
  static const auto kAll = std::make_shared<const Member>(Member{std::string(kLanMember)});
  PeerIdentity identity{id, incarnation, start.host, shared_.options.judge ? kAll : nullptr};
  identity.own_process = std::any_of(shared_.links.begin(), shared_.links.end(), [&start](const auto* link) {
    return participant_of(link->participant()) == start.participant;
  });
  return identity;
}

void DdsLink::on_presence(const PresenceNews& news) {
  const auto [id, incarnation] = news.who;
  if (id == self_)
    return news.there ? id_conflicts_.seen(incarnation, news.start.participant) : id_conflicts_.gone(incarnation);
  if (!news.there) return on_absence(news);
  if (auto* peer = find_or_add_peer(id); peer && listener_) add_start(*peer, news);
}

void DdsLink::add_start(Peer& peer, const PresenceNews& news) {
  const auto [id, incarnation] = news.who;
  const auto& who = news.start.participant;
  const auto known = peer.alive.find(incarnation);
  if (known != peer.alive.end() && known->second.participant != who) {
    known->second.heir = std::make_shared<const Peer::Start>(news.start);
    return warn(fmt::format("forged {}", number(id)),
                fmt::format("another DDS participant claims to be component {}, with the same start: ignored while the "
                            "first one is there",
                            number(id)));
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

/// The start to forget: of those between the earliest, which is the genuine one unless a clock was set back, and the
/// newcomer, the one that arrived last.
Peer::Starts::iterator DdsLink::excess_start(Peer& peer, std::uint64_t newcomer) {
  auto last = peer.alive.end();
  for (auto one = std::next(peer.alive.begin()); one != peer.alive.end(); ++one) {
    if (one->first == newcomer) continue;
    if (last == peer.alive.end() || one->second.place > last->second.place) last = one;
  }
  return last;
}

void DdsLink::remove_start(OwnerId id, Peer& peer, Peer::Starts::iterator start) {
  participants_.remove(start->second.participant, {id, start->first});
  peer.alive.erase(start);
}

void DdsLink::on_absence(const PresenceNews& news) {
  const auto [id, incarnation] = news.who;
  const auto found = peers_.find(id);
  if (found == peers_.end()) return;
  const auto start = found->second.alive.find(incarnation);
  if (start == found->second.alive.end()) return;
  auto& heir = start->second.heir;
  if (heir && heir->publication == news.start.publication) heir.reset();
  if (start->second.publication == news.start.publication) end_start(news.who, news.left);
}

void DdsLink::end_start(const Participants::Start& who, bool left) {
  const auto [id, incarnation] = who;
  const auto found = peers_.find(id);
  if (found == peers_.end()) return;
  const auto start = found->second.alive.find(incarnation);
  if (start == found->second.alive.end()) return;
  const auto heir = start->second.heir;
  remove_start(id, found->second, start);
  select_incarnation(id, found->second, left);
  if (!heir || !listener_) return;
  if (auto* peer = find_or_add_peer(id); peer && listener_)
    add_start(*peer, {who, true, false, kProtocolVersion, *heir});
}

/// A presence lives as long as its publication is matched, whatever others do with the instance.
void DdsLink::end_unmatched() {
  dds_subscription_matched_status_t status;
  if (dds_get_subscription_matched_status(presence_reader_.get(), &status) != DDS_RETCODE_OK) return;
  const auto unmatched = status.total_count - status.current_count;
  if (std::exchange(unmatched_seen_, unmatched) == unmatched) return;
  const auto there = matched_writers({presence_reader_.get()});
  std::vector<PresenceNews> gone;
  for (const auto& [id, peer] : peers_) {
    for (const auto& [incarnation, start] : peer.alive) {
      for (const auto* one : {&start, start.heir.get()}) {
        if (one && !there.contains(one->publication)) gone.push_back({{id, incarnation}, false, false, 0, *one});
      }
    }
  }
  for (const auto& one : gone) {
    if (!listener_) return;
    starts_->note({one.who.first, one.who.second, 0, false, {}});
    on_absence(one);
  }
  if (listener_) drop_interests_of_gone();
}

/// Ignores the participant and all its components for as long as it is present.
void DdsLink::ban(const Participant& who) {
  warn("banned",
       fmt::format("one DDS participant claims more than {} components: it is ignored", Participants::kMaxComponents));
  shut_out(who);
}

void DdsLink::shut_out(const Participant& who) {
  for (const auto& start : participants_.ban(who)) {
    starts_->note({start.first, start.second, kProtocolVersion, false, {}});
    end_start(start, false);
  }
  interests_.erase_all(who);
}

/// nullptr: too many peers.
Peer* DdsLink::find_or_add_peer(OwnerId id) {
  if (const auto found = peers_.find(id); found != peers_.end()) return &found->second;
  if (peers_.size() >= kMaxPeers) evict_peers();
  if (peers_.size() < kMaxPeers) return &peers_[id];
  warn("peers", fmt::format("component {} is ignored: there are {} others already", number(id), peers_.size()));
  return nullptr;
}

/// Removes the peers that went down; if that is not enough, bans the participant with most components.
void DdsLink::evict_peers() {
  forget_gone_peers();
  if (peers_.size() < kMaxPeers) return;
  if (const auto largest = participants_.largest()) ban(*largest);
  forget_gone_peers();
}

void DdsLink::forget_gone_peers() {
  std::erase_if(peers_, [](const auto& one) { return one.second.alive.empty() && !one.second.is_up(); });
}

void DdsLink::drop_gone_peers() {
  for (; gone_.size() > kMaxGone; gone_.pop_front()) {
    const auto found = peers_.find(gone_.front());
    if (found == peers_.end() || !found->second.alive.empty() || found->second.is_up()) continue;
    peers_.erase(found);
  }
}

/// Makes the latest start that is present the peer's incarnation.
void DdsLink::select_incarnation(OwnerId id, Peer& peer, bool left) {
  const auto wanted = peer.alive.empty() ? 0 : peer.alive.rbegin()->first;
  if (wanted == peer.incarnation) return report_summary(id, peer);
  if (peer.is_up()) peer_down(id, peer, left ? PeerEvent::kLeft : PeerEvent::kLost);
  if (wanted != 0 && listener_) peer_up(id, peer, wanted);
}

void DdsLink::report_summary(OwnerId id, Peer& peer) {
  if (!listener_ || !peer.is_up()) return;
  const auto& summary = peer.alive.at(peer.incarnation).summary;
  if (summary == peer.summary) return;
  peer.summary = summary;
  listener_->on_summary(id, peer.summary);
}

void DdsLink::peer_up(OwnerId id, Peer& peer, std::uint64_t incarnation) {
  const auto& start = peer.alive.at(incarnation);
  const EarlyFrames::Sender sender{id, incarnation, start.participant};
  peer.incarnation = incarnation;
  peer.participant = start.participant;
  peer.host = start.host;
  if (std::exchange(peer.requests_of, incarnation) != incarnation) peer.last_request = 0;
  peer.summary.clear();
  peer.ages = {};
  // It may not have noticed that it was lost here, or that another start was followed: it sends its snapshots again if
  // it is asked.
  if (incarnation <= peer.latest) repeat_soon_.request();
  peer.latest = std::max(peer.latest, incarnation);
  const auto identity = identity_of(id, incarnation, start);
  policy_->peer_up(identity);
  listener_->on_peer(identity, PeerEvent::kUp);
  if (listener_) report_summary(id, peer);
  for (const auto& spec : interests_.of(id, incarnation, sender.participant)) {
    if (listener_) listener_->on_subscribe(id, spec);
  }
  for (const auto& content : early_frames_.take(sender)) {
    if (listener_) deliver(id, content);
  }
}

void DdsLink::peer_down(OwnerId id, Peer& peer, PeerEvent event) {
  const PeerIdentity identity{id, std::exchange(peer.incarnation, 0), peer.host};
  peer.channel.reset();
  gone_.push_back(id);
  listener_->on_peer(identity, event);
  policy_->peer_down(id);
}

/// So that nothing is kept of participants that come and go.
void DdsLink::drop_gone_writers() {
  const auto there = matched_writers({presence_reader_.get(), interest_reader_.get(), frame_reader_.get()});
  participants_.keep_only(writers_.keep_only(there));
  for (auto* quota : {&stores_->presence_quota, &stores_->interest_quota}) quota->keep_only(there);
}

std::set<Participant> DdsLink::participants_with_components() const {
  auto all = participants_matched(presence_reader_.get());
  all.insert(participant_of(participant_.get()));
  return all;
}

}  // namespace rubicon::tuples::dds
