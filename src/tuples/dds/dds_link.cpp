#include "tuples/dds/dds_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <system_error>
#include <thread>
#include <utility>

#include "transport/host_names.h"
#include "tuples/peer_policy.h"
#include "tuples/refusals.h"
#include "wire.h"  // made from wire.idl

namespace rubicon::tuples::dds {

namespace {

/// Bytes that may wait for one component; beyond them publish() and remote_set() refuse.
constexpr std::size_t kMaxWaitingBytes = 512 * 1024;
constexpr std::size_t kMaxSetsWaiting = 32 * 1024 * 1024;
/// Pause before writing again to a component that accepts nothing.
constexpr Duration kRetry = std::chrono::milliseconds(1);
constexpr Duration kRepeatPause = std::chrono::seconds(1);

std::unique_ptr<PeerPolicy> policy_of(OwnerId self, const DdsOptions& options, const Log& log) {
  if (options.judge) return std::make_unique<MemberPolicy>(self, options.judge);
  return std::make_unique<DeclaredHostPolicy>(self, transport::host_id("host"), options.trust_lan, log);
}

/// Estimated size of an entry, with its numbers.
std::size_t size_of(const Change& change) {
  return text_size(change) + 64;
}

}  // namespace

bool LinkShared::has(const Participant& who) const {
  return std::any_of(links.begin(), links.end(),
                     [&who](const auto* link) { return participant_of(link->participant()) == who; });
}

DdsLink::DdsLink(StandIn who, Entity participant, LinkShared& shared)
    : own_{who.id},
      shared_(shared),
      log_(Log(shared.log, "dds"), shared.scheduler),
      host_(who.host.empty() ? transport::host_id("host") : std::move(who.host)),
      policy_(policy_of(own_.id, shared.options, log_.unlimited())),
      signal_(shared.post, [this](unsigned sources) { drain(sources); }),
      entities_(own_.id, shared.options.lease, signal_, std::move(participant)),
      id_conflicts_(own_.id, shared.scheduler, shared.options.lease, log_.unlimited(),
                    {[this](std::uint64_t incarnation) {
                       return Channel::make({own_.id, own_.id, own_.incarnation, incarnation}, entities_.participant(),
                                            entities_.frame_topic(), signal_.listener(Signal::kWriter));
                     },
                     std::move(who.displaced), carrier_of(host_) == model::kNoOwner}),
      presences_(own_, shared, entities_, *policy_, id_conflicts_, log_, *this),
      subscribers_(own_, shared, entities_, presences_, log_),
      frames_(
          own_, shared, entities_, presences_, id_conflicts_, log_,
          {[this](const Reply& answer) { reply(answer); }, [this](OwnerId to, bool asks) { send_times(to, asks); }}),
      flush_soon_(shared.scheduler, [this] { flush(); }),
      repeat_soon_(shared.scheduler, kRepeatPause, [this] { repeat_interests(); }),
      flush_retry_(shared.scheduler, [this] { flush(); }) {
  shared_.links.insert(this);
}

Result<std::unique_ptr<DdsLink>> DdsLink::make(StandIn who, Entity participant, LinkShared& shared) {
  std::unique_ptr<DdsLink> link(new DdsLink(std::move(who), std::move(participant), shared));
  if (auto done = link->entities_.make(); !done) return fail(std::move(done.error()));
  return link;
}

DdsLink::~DdsLink() {
  shared_.links.erase(this);
  leave();
  delete_apart([this] { entities_.delete_all(); });
}

std::set<Participant> DdsLink::participants_with_components() const {
  auto all = participants_matched(entities_.presence_reader());
  all.insert(participant_of(entities_.participant()));
  return all;
}

// -- a start of the component: enters, and leaves

void DdsLink::attach(LinkListener& listener, std::uint64_t incarnation) {
  leave();
  if (auto done = entities_.make(); !done) return log_.unlimited().error(done.error().text);
  own_.listener = &listener;
  own_.incarnation = std::max(incarnation, own_.incarnation + 1);
  if (entities_.in_domain()) enter();  // else resume() does it
}

void DdsLink::enter() {
  id_conflicts_.begin(own_.incarnation);
  if (!write_presence()) retry_flush();
  for (const auto source : {Signal::kPresence, Signal::kInterests, Signal::kFrames}) signal_.raise(source);
}

/// Announces that this component leaves, and forgets all others. Keeps entities that no listener used yet.
void DdsLink::leave() {
  if (!own_.listener) return;
  flush();  // sends what can still be sent
  own_.listener = nullptr;
  flush_retry_.clear();
  interests_.clear();
  if (entities_.in_domain()) say_goodbye();
  drop_held();
  presences_.clear();
  frames_.clear();
  delete_apart([this] {
    channels_.clear();
    entities_.delete_readers_and_writers();
  });
}

namespace {

void drop_frames(dds_entity_t reader) {
  take<rubicon_wire_Frame>(reader, kSamples, [](const auto&, const auto&) {});
}

}  // namespace

/// Deletes on a thread of its own and waits for it, while the frames of all links are taken from the wire. Cyclone DDS
/// deletes when its receiving thread has passed, and that waits as long as any reader of frames of the process is full:
/// a loop that only waited for the deletion would wait for ever.
void DdsLink::delete_apart(const std::function<void()>& removal) {
  std::atomic<bool> done = false;
  std::thread thread;
  const auto own = own_.listener ? 0 : entities_.frame_reader();
  try {
    thread = std::thread([&] {
      removal();
      done = true;
    });
  } catch (const std::system_error&) {
    return removal();  // the system has no thread to give
  }
  while (!done) {
    for (auto* link : shared_.links) link->collect_frames();
    if (own > 0) drop_frames(own);
    dds_sleepfor(DDS_USECS(200));
  }
  thread.join();
}

void DdsLink::collect_frames() {
  if (!own_.listener) return drop_frames(entities_.frame_reader());
  if (frames_.collect() > 0) signal_.raise(Signal::kFrames);
}

void DdsLink::say_goodbye() {
  rubicon_wire_Presence presence{};
  presence.id = number(own_.id);
  presence.incarnation = own_.incarnation;
  presence.host = host_.data();
  presence.summary = summary_.data();
  dds_dispose(entities_.presence_writer(), &presence);
  dds_unregister_instance(entities_.presence_writer(), &presence);
  await_receivers();
}

/// Until the others have what was written: last replies, and that this component left.
void DdsLink::await_receivers() {
  for (const auto& [id, channel] : channels_) shared_.patience.await(channel->writer());
  for (const auto writer : {entities_.interest_writer(), entities_.presence_writer()}) shared_.patience.await(writer);
}

/// What came in this domain and waits.
void DdsLink::drop_held() {
  id_conflicts_.begin(0);
  subscribers_.clear();
  frames_.drop_held();
}

/// What waits in the channels is lost: others ask for snapshots when they meet this component again.
void DdsLink::leave_behind(FormerDomain::Remains& remains) {
  if (!entities_.in_domain()) return;
  if (own_.listener) frames_.take();
  for (auto& [id, channel] : channels_) remains.channels.push_back(std::move(channel));
  channels_.clear();
  entities_.leave_behind(remains);
  presences_.lose_all();
  drop_held();
}

Result<void> DdsLink::resume(Entity participant) {
  if (auto done = entities_.make_in(std::move(participant)); !done) return done;
  if (!own_.listener) return {};
  correct_start();
  repeat_interests();
  enter();
  return {};
}

/// A start before the clock of this host was set counts from when it was. The carrier knows its stand-ins by their
/// start.
void DdsLink::correct_start() {
  const auto now = static_cast<std::uint64_t>(shared_.scheduler.wall_now().time_since_epoch().count());
  if (own_.incarnation < DeclaredHostPolicy::kEarliest && carrier_of(host_) == model::kNoOwner)
    own_.incarnation = std::max(now, own_.incarnation);
}

// -- what arrives

/// Processes the samples that arrived. Each listener call may detach the link.
void DdsLink::drain(unsigned sources) {
  if (!entities_.in_domain()) return;
  if (own_.listener && (sources & Signal::kPresence) != 0 && take_presences()) signal_.raise(Signal::kPresence);
  if (own_.listener && (sources & Signal::kInterests) != 0 && subscribers_.take()) signal_.raise(Signal::kInterests);
  if (own_.listener && (sources & Signal::kFrames) != 0 && frames_.take()) signal_.raise(Signal::kFrames);
  if (own_.listener && (sources & Signal::kWriter) != 0) flush();
  if (own_.listener) presences_.forget_gone_writers();
}

/// True: more may be waiting.
bool DdsLink::take_presences() {
  const auto arrived = presences_.take();
  // What a component sent before it left arrived before its absence, such as its last replies.
  if (arrived.some_ended && frames_.take()) signal_.raise(Signal::kFrames);
  if (presences_.apply(arrived.news)) subscribers_.drop_gone();
  return arrived.more;
}

/// One that was up before may not have noticed that it was lost here, or that this link followed another start. It
/// sends its snapshots again on request.
void DdsLink::on_met(const Sender& sender, bool again) {
  if (again) repeat_soon_.request();
  subscribers_.met(sender);
  if (own_.listener) frames_.met(sender);
}

void DdsLink::on_lost(OwnerId id) {
  if (auto channel = channels_.extract(id)) delete_apart([&] { channel.mapped().reset(); });
  frames_.lost(id);
}

// -- what is sent

/// nullptr: no such component is up, or DDS makes no channel.
Channel* DdsLink::channel_to(OwnerId id) {
  const auto* peer = presences_.find_up(id);
  if (!peer) return nullptr;
  if (const auto found = channels_.find(id); found != channels_.end()) return found->second.get();
  auto channel = Channel::make({own_.id, id, own_.incarnation, peer->incarnation}, entities_.participant(),
                               entities_.frame_topic(), signal_.listener(Signal::kWriter));
  if (!channel) return log_.warning("channel", channel.error().text), nullptr;
  return (channels_[id] = std::move(*channel)).get();
}

bool DdsLink::publish(OwnerId subscriber, std::span<const Change> changes) {
  if (!presences_.find_up(subscriber)) return true;  // no receiver: dropped
  auto* channel = channel_to(subscriber);
  if (!channel || channel->waiting() > kMaxWaitingBytes) return false;
  distant::FrameWriter entries;
  for (const auto& change : changes) {
    if (entries.size() > 0 && entries.size() + size_of(change) > Channel::kFrameBytes) channel->add(entries.take());
    entries.add(change);
  }
  if (entries.size() > 0) channel->add(entries.take());
  const auto state = write_frames(subscriber, *channel);  // all changes of a turn come at once
  if (state == Channel::State::kFull) retry_flush();
  if (state == Channel::State::kMore) flush_soon_.request();
  return true;
}

Result<void> DdsLink::remote_set(const RemoteSet& set) {
  if (!presences_.find_up(set.owner)) return fail(no_component(set.owner));
  auto* channel = channel_to(set.owner);
  if (!channel || channel->waiting() > kMaxSetsWaiting) return fail(takes_no_requests(set.owner));
  channel->add(set, shared_.scheduler.now());
  flush_soon_.request();
  return {};
}

/// Replies beyond the bound are dropped: a component that sends many requests and reads no replies loses them.
void DdsLink::reply(const Reply& reply) {
  auto* channel = channel_to(reply.to);
  if (!channel) return;
  if (channel->waiting() > kMaxSetsWaiting) return void(log_.warning("replies", unread_replies(reply.to)));
  channel->add(reply);
  flush_soon_.request();
}

void DdsLink::send_times(OwnerId id, bool asks) {
  auto* channel = channel_to(id);
  if (!channel) return;
  channel->add_times(asks);
  flush_soon_.request();
}

void DdsLink::subscribe(const SubscriptionSpec& spec) {
  interests_.put(spec);
  flush_soon_.request();
}

void DdsLink::unsubscribe(std::uint32_t id) {
  if (interests_.erase(id)) flush_soon_.request();
}

/// All owners send the snapshots of all subscriptions again.
void DdsLink::repeat_interests() {
  interests_.repeat();
  flush_soon_.request();
}

void DdsLink::describe(std::string summary) {
  if (summary == summary_) return;
  summary_ = std::move(summary);
  presence_unwritten_ = true;
  flush_soon_.request();
}

bool DdsLink::write_presence() {
  rubicon_wire_Presence presence{};
  presence.id = number(own_.id);
  presence.incarnation = own_.incarnation;
  presence.version = kProtocolVersion;
  presence.host = host_.data();
  presence.summary = summary_.data();
  presence_unwritten_ = dds_write(entities_.presence_writer(), &presence) != DDS_RETCODE_OK;
  return !presence_unwritten_;
}

Channel::State DdsLink::write_frames(OwnerId id, Channel& channel) {
  return channel.flush(shared_.scheduler.now(), [&](bool asks) { return frames_.times_for(id, asks); });
}

void DdsLink::retry_flush() {
  flush_retry_.advance_to(shared_.scheduler.now() + kRetry);
}

void DdsLink::flush() {
  if (!own_.listener || !entities_.in_domain()) return;
  bool full = !interests_.flush(entities_.interest_writer(), own_), more = false;
  if (presence_unwritten_) full |= !write_presence();
  for (auto& [id, channel] : channels_) {
    const auto state = write_frames(id, *channel);
    full |= state == Channel::State::kFull;
    more |= state == Channel::State::kMore;
  }
  if (more) flush_soon_.request();
  if (full) retry_flush();
}

}  // namespace rubicon::tuples::dds
