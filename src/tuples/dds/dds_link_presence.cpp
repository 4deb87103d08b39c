#include <fmt/format.h>

#include "tuples/dds/dds_link.h"
#include "tuples/dds/taking.h"
#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

constexpr std::size_t kMostPeers = 10'000;
/// Components remembered that are not there any more, for what they may still bring.
constexpr std::size_t kMostGone = 100;
constexpr std::size_t kLongestHost = 64;

std::string text_of(const char* text, std::size_t most) {
  return text ? std::string(text).substr(0, most) : std::string();
}

}  // namespace

void DdsLink::take_presences() {
  std::vector<PresenceNews> news;
  take<rubicon_wire_Presence>(presence_reader_.get(), SIZE_MAX, [&](const auto& sample, const auto& info) {
    PresenceNews one;
    one.who = {OwnerId(sample.id), sample.incarnation};
    one.publication = info.publication_handle;
    one.there = info.instance_state == DDS_IST_ALIVE;
    one.left = info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED;
    if (one.there) {
      const auto* writer = info.valid_data ? writers_.find(presence_reader_.get(), info.publication_handle) : nullptr;
      if (!writer) return;
      one.version = sample.version;
      one.start = {writer->participant, text_of(sample.host, kLongestHost), text_of(sample.summary, kMaxSummary + 1)};
      if (one.start.summary.size() > kMaxSummary) one.start.summary.clear();
    } else {
      presence_quota_.release(info.publication_handle, info.instance_handle);
    }
    news.push_back(std::move(one));
  });
  for (const auto& one : news) {
    if (listener_ && is_taken(one)) present(one);
  }
  forget_gone_peers();
}

/// Notes it, unless it is of somebody who is ignored.
bool DdsLink::is_taken(const PresenceNews& news) {
  const auto [id, incarnation] = news.who;
  if (news.there && participants_.is_banned(news.start.participant)) {
    presence_quota_.ban(news.publication);
    return false;
  }
  if (news.who != Participants::Start(self_, incarnation_))
    starts_->note({id, incarnation, news.version, news.there, news.start.summary});
  if (!news.there) return true;
  if (news.version != kProtocolVersion) {
    warn(fmt::format("version {}", number(id)),
         fmt::format("component {} speaks version {} of the protocol, this program version {}: not talked to",
                     number(id), news.version, kProtocolVersion));
    return false;
  }
  const auto may = policy_.may_join({id, incarnation, news.start.host});
  if (!may) warn(fmt::format("refused {}", number(id)), may.error().text + ": ignored");
  return may.has_value();
}

void DdsLink::present(const PresenceNews& news) {
  const auto [id, incarnation] = news.who;
  if (id == self_) return news.there ? twins_.seen(incarnation, news.start.participant) : twins_.gone(incarnation);
  if (!news.there) return absent(news.who, news.left);
  if (auto* peer = know(id); peer && listener_) appear(*peer, news);
}

void DdsLink::appear(Peer& peer, const PresenceNews& news) {
  const auto [id, incarnation] = news.who;
  const auto& who = news.start.participant;
  const auto known = peer.alive.find(incarnation);
  if (known != peer.alive.end() && known->second.participant != who) {
    return warn(fmt::format("forged {}", number(id)),
                fmt::format("somebody else says to be component {}, with the same start: ignored", number(id)));
  }
  if (known == peer.alive.end()) {
    if (!participants_.add(who, news.who)) return ban(who);
    for (auto other = peer.alive.begin(), next = other; other != peer.alive.end(); other = next) {
      next = std::next(other);
      if (other->second.participant == who) forget(id, peer, other);
    }
  }
  const auto place = known == peer.alive.end() ? ++starts_seen_ : known->second.place;
  peer.alive[incarnation] = news.start;
  peer.alive[incarnation].place = place;
  if (peer.alive.size() > Peer::kMostStarts) forget(id, peer, superfluous(peer, incarnation));
  settle(id, peer, false);
}

/// Never the earliest start, which is the genuine one unless somebody set a clock back, nor the one that comes now. Of
/// the others who came first stays: those who push in are not believed more than who was there.
Peer::Starts::iterator DdsLink::superfluous(Peer& peer, std::uint64_t newcomer) {
  auto last = peer.alive.end();
  for (auto one = std::next(peer.alive.begin()); one != peer.alive.end(); ++one) {
    if (one->first == newcomer) continue;
    if (last == peer.alive.end() || one->second.place > last->second.place) last = one;
  }
  return last;
}

void DdsLink::forget(OwnerId id, Peer& peer, Peer::Starts::iterator start) {
  participants_.remove(start->second.participant, {id, start->first});
  peer.alive.erase(start);
}

void DdsLink::absent(const Participants::Start& who, bool left) {
  const auto [id, incarnation] = who;
  const auto found = peers_.find(id);
  if (found == peers_.end()) return;
  const auto start = found->second.alive.find(incarnation);
  if (start == found->second.alive.end()) return;
  forget(id, found->second, start);
  settle(id, found->second, left);
}

/// It and all that it showed is ignored for as long as it is there.
void DdsLink::ban(const Participant& who) {
  warn("banned", fmt::format("one DDS participant shows more than {} components: it is ignored, with all that it says",
                             Participants::kMostComponents));
  for (const auto& start : participants_.ban(who)) {
    starts_->note({start.first, start.second, kProtocolVersion, false, {}});
    absent(start, false);
  }
  interests_.erase_all(who);
}

/// nullptr: there are too many others.
Peer* DdsLink::know(OwnerId id) {
  if (const auto found = peers_.find(id); found != peers_.end()) return &found->second;
  if (peers_.size() >= kMostPeers) make_room();
  if (peers_.size() < kMostPeers) return &peers_[id];
  warn("peers", fmt::format("component {} is not seen: there are {} others", number(id), peers_.size()));
  return nullptr;
}

/// Those that went, else whoever shows most of them.
void DdsLink::make_room() {
  std::erase_if(peers_, [](const auto& one) { return one.second.alive.empty() && !one.second.is_up(); });
  if (peers_.size() < kMostPeers) return;
  if (const auto greatest = participants_.greatest()) ban(*greatest);
  std::erase_if(peers_, [](const auto& one) { return one.second.alive.empty() && !one.second.is_up(); });
}

void DdsLink::forget_gone_peers() {
  for (; gone_.size() > kMostGone; gone_.pop_front()) {
    const auto found = peers_.find(gone_.front());
    if (found != peers_.end() && found->second.alive.empty() && !found->second.is_up()) peers_.erase(found);
  }
}

/// The latest incarnation that is alive is the peer.
void DdsLink::settle(OwnerId id, Peer& peer, bool left) {
  const auto wanted = peer.alive.empty() ? 0 : peer.alive.rbegin()->first;
  if (wanted == peer.incarnation) return tell_summary(id, peer);
  if (peer.is_up()) go(id, peer, left ? PeerEvent::kLeft : PeerEvent::kLost);
  if (wanted != 0 && listener_) come(id, peer, wanted);
}

void DdsLink::tell_summary(OwnerId id, Peer& peer) {
  if (!listener_ || !peer.is_up()) return;
  const auto& summary = peer.alive.at(peer.incarnation).summary;
  if (summary == peer.summary) return;
  peer.summary = summary;
  listener_->on_summary(id, peer.summary);
}

void DdsLink::come(OwnerId id, Peer& peer, std::uint64_t incarnation) {
  const auto& start = peer.alive.at(incarnation);
  const HeldFrames::Sender sender{id, incarnation, start.participant};
  peer.incarnation = incarnation;
  peer.participant = start.participant;
  if (std::exchange(peer.requests_of, incarnation) != incarnation) peer.last_request = 0;
  peer.summary.clear();
  policy_.peer_up({id, incarnation, start.host});
  listener_->on_peer(id, PeerEvent::kUp);
  if (listener_) tell_summary(id, peer);
  for (const auto& spec : interests_.of(id, incarnation, sender.participant)) {
    if (listener_) listener_->on_subscribe(id, spec);
  }
  for (const auto& content : held_.take(sender)) {
    if (listener_) tell(id, content);
  }
}

void DdsLink::go(OwnerId id, Peer& peer, PeerEvent event) {
  peer.incarnation = 0;
  peer.channel.reset();
  gone_.push_back(id);
  listener_->on_peer(id, event);
  policy_.peer_down(id);
}

/// Nothing may be kept of those who come and go.
void DdsLink::forget_gone_writers() {
  const auto there = matched_writers({presence_reader_.get(), interest_reader_.get(), frame_reader_.get()});
  participants_.keep_only(writers_.keep_only(there));
}

}  // namespace rubicon::tuples::dds
