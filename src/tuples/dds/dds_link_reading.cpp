#include <fmt/format.h>

#include <charconv>

#include "tuples/dds/dds_link.h"
#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

/// Samples taken at a time, and frames told in one turn of the loop.
constexpr std::uint32_t kSamples = 64;
/// Frames that DDS keeps for a loop that is busy; then it holds up their writers.
constexpr std::int32_t kQueuedFrames = 64;
constexpr std::size_t kMostHeld = 1 << 20;
/// Components remembered that are not there, for what they may still bring.
constexpr std::size_t kMostPeers = 10'000;
constexpr std::size_t kLongestHost = 64;

/// Takes everything (or `most` samples) there is; each sample is told once, valid or not.
template <class Sample, class Tell>
std::size_t take(dds_entity_t reader, std::size_t most, Tell tell) {
  void* samples[kSamples] = {};
  dds_sample_info_t infos[kSamples];
  std::size_t total = 0;
  while (total < most) {
    const auto count = dds_take(reader, samples, infos, kSamples, kSamples);
    if (count <= 0) break;
    for (int i = 0; i < count; ++i) tell(*static_cast<const Sample*>(samples[i]), infos[i]);
    dds_return_loan(reader, samples, count);
    total += static_cast<std::size_t>(count);
  }
  return total;
}

ByteView view(const dds_sequence_octet& octets) {
  return {octets._buffer, octets._length};
}

}  // namespace

Result<void> DdsLink::make_readers() {
  const auto pp = participant_.get();
  const auto topic = [pp](Entity& entity, const dds_topic_descriptor_t* type, const char* name) -> Result<void> {
    if (entity) return {};
    auto topic_made = made(dds_create_topic(pp, type, name, nullptr, nullptr), name);
    if (!topic_made) return fail(std::move(topic_made.error()));
    entity = std::move(*topic_made);
    return {};
  };
  if (auto done = topic(presence_topic_, &rubicon_wire_Presence_desc, "rubicon_presence"); !done) return done;
  if (auto done = topic(interest_topic_, &rubicon_wire_Interest_desc, "rubicon_interests"); !done) return done;
  if (auto done = topic(frame_topic_, &rubicon_wire_Frame_desc, "rubicon_frames"); !done) return done;

  auto frames = make_qos();
  dds_qset_reliability(frames.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_history(frames.get(), DDS_HISTORY_KEEP_ALL, 0);
  dds_qset_resource_limits(frames.get(), kQueuedFrames, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  auto partition = make_qos();
  dds_qset_partition1(partition.get(), fmt::format("*.{}", number(self_)).c_str());
  auto subscriber = made(dds_create_subscriber(pp, partition.get(), nullptr), "subscriber of frames");
  if (!subscriber) return fail(std::move(subscriber.error()));
  frame_subscriber_ = std::move(*subscriber);
  // Asks for no lease: that would hide all components with a longer one. Each is lost by its own.
  const auto reader = [this](Entity& entity, dds_entity_t parent, const Entity& of, const Qos& qos,
                             Signal::Source source) -> Result<void> {
    auto reader_made = made(dds_create_reader(parent, of.get(), qos.get(), signal_.listener(source)), "reader");
    if (!reader_made) return fail(std::move(reader_made.error()));
    entity = std::move(*reader_made);
    return {};
  };
  if (auto done = reader(frame_reader_, frame_subscriber_.get(), frame_topic_, frames, Signal::kFrames); !done)
    return done;
  if (auto done = reader(interest_reader_, pp, interest_topic_, make_kept_qos(), Signal::kInterests); !done)
    return done;
  return reader(presence_reader_, pp, presence_topic_, make_kept_qos(), Signal::kPresence);
}

/// What DDS brought. Each listener call may end the link's attachment.
void DdsLink::drain(unsigned sources) {
  if (listener_ && (sources & Signal::kPresence) != 0) take_presences();
  if (listener_ && (sources & Signal::kInterests) != 0) take_interests();
  if (listener_ && (sources & Signal::kFrames) != 0 && take_frames()) signal_.raise(Signal::kFrames);
  if (listener_ && (sources & Signal::kWriter) != 0) flush();
}

void DdsLink::take_presences() {
  std::vector<PresenceNews> news;
  take<rubicon_wire_Presence>(presence_reader_.get(), SIZE_MAX, [&](const auto& sample, const auto& info) {
    const bool there = info.instance_state == DDS_IST_ALIVE;
    if (there && !info.valid_data) return;
    news.push_back({OwnerId(sample.id), sample.incarnation, there, info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED,
                    sample.version, there && sample.summary ? sample.summary : "",
                    there && sample.host ? std::string(sample.host).substr(0, kLongestHost) : ""});
    if (news.back().summary.size() > kMaxSummary) news.back().summary.clear();
  });
  for (const auto& one : news) {
    if (listener_ && speaks_as_we(one)) present(one);
  }
}

/// Notes it in any case.
bool DdsLink::speaks_as_we(const PresenceNews& news) {
  if (news.id != self_ || news.incarnation != incarnation_)
    appearances_->note({news.id, news.incarnation, news.version, news.there, news.summary});
  if (!news.there || news.version == kProtocolVersion) return true;
  warn(fmt::format("version {}", number(news.id)),
       fmt::format("component {} speaks version {} of the protocol, this program version {}: not talked to",
                   number(news.id), news.version, kProtocolVersion));
  return false;
}

void DdsLink::present(const PresenceNews& news) {
  const auto [id, incarnation, there, left, version, summary, host] = news;
  if (incarnation == 0) return;
  if (id == self_) {
    // The later one goes, so that all who look decide alike.
    if (there && incarnation < incarnation_ && !std::exchange(is_displaced_, true)) scheduler_.post(displaced_);
    return;
  }
  auto* known = know(id);
  if (!known) return;
  auto& peer = *known;
  if (there) peer.host = host;
  there ? void(peer.alive[incarnation] = summary) : void(peer.alive.erase(incarnation));
  settle(id, peer, left);
}

/// nullptr: there are too many others. Those that went make room.
Peer* DdsLink::know(OwnerId id) {
  if (const auto found = peers_.find(id); found != peers_.end()) return &found->second;
  if (peers_.size() >= kMostPeers)
    std::erase_if(peers_, [](const auto& one) { return one.second.alive.empty() && !one.second.is_up(); });
  if (peers_.size() < kMostPeers) return &peers_[id];
  warn("peers", fmt::format("component {} is not seen: there are {} others", number(id), peers_.size()));
  return nullptr;
}

/// The latest incarnation that is alive is the peer.
void DdsLink::settle(OwnerId id, Peer& peer, bool left) {
  const auto wanted = peer.alive.empty() ? 0 : peer.alive.rbegin()->first;
  if (wanted == peer.incarnation) return tell_summary(id, peer);
  if (peer.is_up()) go(id, peer, left ? PeerEvent::kLeft : PeerEvent::kLost);
  if (wanted != 0 && listener_) come(id, peer, wanted);
}

void DdsLink::tell_summary(OwnerId id, Peer& peer) {
  if (!listener_ || !peer.is_up() || peer.alive.at(peer.incarnation) == peer.summary) return;
  peer.summary = peer.alive.at(peer.incarnation);
  listener_->on_summary(id, peer.summary);
}

void DdsLink::come(OwnerId id, Peer& peer, std::uint64_t incarnation) {
  peer.incarnation = incarnation;
  if (std::exchange(peer.requests_of, incarnation) != incarnation) peer.last_request = 0;
  peer.summary.clear();
  listener_->on_peer(id, PeerEvent::kUp);
  tell_summary(id, peer);
  for (const auto& [slot, one] : std::map(peer.interests)) {
    if (listener_ && one.incarnation == incarnation) listener_->on_subscribe(id, one.spec);
  }
  while (listener_ && !peer.held.empty()) {
    const auto held = std::move(peer.held.front());
    peer.held.pop_front();
    peer.held_bytes -= held.content.size();
    if (held.incarnation == incarnation) tell(id, held.content);
  }
}

void DdsLink::go(OwnerId id, Peer& peer, PeerEvent event) {
  peer.incarnation = 0;
  peer.channel.reset();
  listener_->on_peer(id, event);
}

void DdsLink::take_interests() {
  struct News {
    OwnerId id;
    std::uint64_t incarnation;
    std::uint32_t slot;
    std::optional<SubscriptionSpec> spec;
  };
  std::vector<News> news;
  take<rubicon_wire_Interest>(interest_reader_.get(), SIZE_MAX, [&](const auto& sample, const auto& info) {
    const OwnerId id{sample.subscriber};
    News one{id, sample.incarnation, sample.slot, {}};
    if (info.valid_data && info.instance_state == DDS_IST_ALIVE) {
      auto spec = read_subscription(view(sample.content));
      if (!spec) return warn(fmt::format("interest {}", sample.subscriber), spec.error().text);
      one.spec = std::move(*spec);
    }
    if (id != self_) news.push_back(std::move(one));
  });
  for (auto& one : news) {
    if (listener_) interest(one.id, one.incarnation, one.slot, std::move(one.spec));
  }
}

void DdsLink::interest(OwnerId id, std::uint64_t incarnation, std::uint32_t slot,
                       std::optional<SubscriptionSpec> spec) {
  auto* from = know(id);
  if (!from) return;
  auto& peer = *from;
  const auto before = peer.interests.find(slot);
  const bool known = before != peer.interests.end();
  if (known && before->second.incarnation > incarnation) return;  // late news of an earlier start
  const bool same_start = known && before->second.incarnation == incarnation;
  const bool counts = peer.is_up() && peer.incarnation == incarnation;
  if (same_start && counts && (!spec || spec->id != before->second.spec.id))
    listener_->on_unsubscribe(id, before->second.spec.id);
  if (!spec) {
    if (same_start) peer.interests.erase(slot);
    return;
  }
  if (!known && peer.interests.size() >= kMostPeers)
    return warn(fmt::format("interests {}", number(id)),
                fmt::format("component {} has too many subscriptions", number(id)));
  const auto told = *spec;
  peer.interests[slot] = {incarnation, std::move(*spec)};
  if (counts && listener_) listener_->on_subscribe(id, told);
}

/// True: there may be more.
bool DdsLink::take_frames() {
  struct News {
    OwnerId source;
    std::uint64_t incarnation;
    Bytes content;
  };
  std::vector<News> news;
  const auto count = take<rubicon_wire_Frame>(frame_reader_.get(), kSamples, [&](const auto& sample, const auto& info) {
    if (!info.valid_data || sample.target_incarnation != incarnation_) return;
    const OwnerId source{sample.source};
    const auto owner = owner_of(info.publication_handle);
    if (!owner) return;  // it went before its first word was read: whose it was cannot be known any more
    if (*owner != source)
      return warn(
          fmt::format("forged {}", sample.source),
          fmt::format("frames that say they are from component {} come from another one: dropped", sample.source));
    const auto bytes = view(sample.content);
    news.push_back({source, sample.source_incarnation, Bytes(bytes.begin(), bytes.end())});
  });
  for (const auto& one : news) {
    if (listener_) frame(one.source, one.incarnation, one.content);
  }
  return count >= kSamples;
}

/// Whose writer it is: the first part of its partition, that only its owner may have.
std::optional<OwnerId> DdsLink::owner_of(dds_instance_handle_t publication) {
  const auto known = publications_.find(publication);
  if (known != publications_.end()) return known->second;
  std::optional<OwnerId> owner;
  if (auto* endpoint = dds_get_matched_publication_data(frame_reader_.get(), publication)) {
    std::uint32_t count = 0;
    char** names = nullptr;
    if (dds_qget_partition(endpoint->qos, &count, &names) && count == 1) {
      const std::string_view name = names[0];
      std::uint32_t id = 0;
      const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
      if (error == std::errc() && end != name.data() + name.size() && *end == '.') owner = OwnerId(id);
    }
    for (std::uint32_t i = 0; i < count; ++i) dds_free(names[i]);
    dds_free(names);
    dds_builtintopic_free_endpoint(endpoint);
  }
  if (publications_.size() >= kMostPeers) publications_.clear();
  if (owner) publications_.emplace(publication, owner);
  return owner;
}

void DdsLink::frame(OwnerId source, std::uint64_t incarnation, ByteView content) {
  auto* peer = know(source);
  if (!peer) return;
  if (peer->incarnation == incarnation) return tell(source, content);
  if (incarnation > peer->incarnation) hold(*peer, incarnation, content);
}

void DdsLink::hold(Peer& peer, std::uint64_t incarnation, ByteView content) {
  if (peer.held_bytes + content.size() > kMostHeld) return warn("held", "frames of a component nobody knows: dropped");
  peer.held.push_back({incarnation, Bytes(content.begin(), content.end())});
  peer.held_bytes += content.size();
}

void DdsLink::tell(OwnerId id, ByteView content) {
  reading_from_ = id;
  if (auto read = read_frame(content, id, self_, *this); !read)
    warn(fmt::format("frame {}", number(id)), read.error().text);
}

void DdsLink::on_changes(std::span<const Change> changes) {
  if (listener_) listener_->on_changes(reading_from_, changes);
}

void DdsLink::on_set(RemoteSet&& wish) {
  auto& peer = peers_[reading_from_];
  if (!listener_ || wish.request <= peer.last_request) return;  // a repetition
  peer.last_request = wish.request;
  if (!refuses(peer, wish)) listener_->on_remote_set(wish);
}

/// Who runs elsewhere may read; to set, it has to be trusted. Answers if so.
bool DdsLink::refuses(Peer& peer, const RemoteSet& wish) {
  if (trusts_others_ || peer.host == host_) return false;
  ++refused_;
  if (!std::exchange(peer.was_refused, true)) {
    log_.warning(
        fmt::format("remote sets of component {} are refused: it runs on another host, and tuples.trust_lan is no",
                    number(wish.from)));
  }
  reply({wish.from, wish.request, Verdict::kRefused, ErrorCode::kRefused,
         fmt::format("setting '{}': component {} takes no remote sets from other hosts (its tuples.trust_lan is no)",
                     wish.key, number(self_))});
  return true;
}

void DdsLink::on_reply(Reply&& reply) {
  if (listener_) listener_->on_reply(reply);
}

}  // namespace rubicon::tuples::dds
