#include "tuples/dds/dds_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "transport/host_name.h"
#include "tuples/host_policy.h"
#include "tuples/member_policy.h"
#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

/// Bytes that may wait for one component; beyond them publish() and remote_set() refuse.
constexpr std::size_t kMaxWaitingBytes = 512 * 1024;
constexpr std::size_t kMaxSetsWaiting = 32 * 1024 * 1024;
/// Pause before writing again to a component that accepts nothing.
constexpr Duration kRetry = std::chrono::milliseconds(1);
/// Frames that DDS queues while the loop is busy; then their writers have to wait.
constexpr std::int32_t kQueuedFrames = 64;

rubicon_wire_Interest interest_of(OwnerId id, std::uint64_t incarnation, std::uint32_t slot, const Bytes& content) {
  rubicon_wire_Interest interest{};
  interest.subscriber = number(id);
  interest.incarnation = incarnation;
  interest.slot = slot;
  interest.content._maximum = interest.content._length = static_cast<std::uint32_t>(content.size());
  interest.content._buffer = const_cast<std::uint8_t*>(content.data());  // written, never changed
  return interest;
}

std::unique_ptr<PeerPolicy> policy_of(OwnerId self, const DdsOptions& options, const Log& log) {
  if (options.judge) return std::make_unique<MemberPolicy>(self, options.judge);
  return std::make_unique<HostPolicy>(self, transport::host_id("host"), options.trust_lan, log);
}

/// Estimated size of an entry, with its numbers.
std::size_t size_of(const Change& change) {
  return text_size(change) + 64;
}

}  // namespace

DdsLink::DdsLink(StandIn who, Entity participant, Shared& shared)
    : self_(who.id),
      shared_(shared),
      scheduler_(shared.scheduler),
      log_(shared.log, "dds"),
      limited_log_(log_, scheduler_),
      lease_(shared.options.lease),
      host_(who.host.empty() ? transport::host_id("host") : std::move(who.host)),
      policy_(policy_of(self_, shared.options, log_)),
      starts_(shared.starts),
      signal_(shared.post, [this](unsigned sources) { drain(sources); }),
      participant_(std::move(participant)),
      id_conflicts_(self_, scheduler_, lease_, log_,
                    {[this](std::uint64_t incarnation) {
                       return Channel::make({self_, self_, incarnation_, incarnation}, participant_.get(),
                                            frame_topic_.get(), signal_.listener(Signal::kWriter));
                     },
                     std::move(who.displaced), carrier_of(host_) == model::kNoOwner}) {
  shared_.links.insert(this);
}

Result<std::unique_ptr<DdsLink>> DdsLink::make(StandIn who, Entity participant, Shared& shared) {
  std::unique_ptr<DdsLink> link(new DdsLink(std::move(who), std::move(participant), shared));
  if (auto done = link->make_entities(); !done) return fail(std::move(done.error()));
  return link;
}

DdsLink::~DdsLink() {
  shared_.links.erase(this);
  leave();
}

void DdsLink::attach(LinkListener& listener, std::uint64_t incarnation) {
  leave();
  if (auto done = make_entities(); !done) return log_.error(done.error().text);
  listener_ = &listener;
  incarnation_ = std::max(incarnation, incarnation_ + 1);
  if (!participant_) return;  // resume() does the rest
  id_conflicts_.begin(incarnation_);
  if (!write_presence()) retry_flush();
  for (const auto source : {Signal::kPresence, Signal::kInterests, Signal::kFrames}) signal_.raise(source);
}

/// Does nothing if they exist, or while the link is outside of the domain. Readers are made first, so that a component
/// that sees this one can reach it.
Result<void> DdsLink::make_entities() {
  if (presence_writer_ || !participant_) return {};
  auto done = make_topics();
  if (done) done = make_readers();
  if (done) done = make_writers();
  return done;
}

Result<void> DdsLink::make_topics() {
  const auto make_one = [this](Entity& entity, const dds_topic_descriptor_t* type, const char* name) -> Result<void> {
    if (entity) return {};
    auto topic =
        made(dds_create_topic(participant_.get(), type, name, nullptr, nullptr), fmt::format("topic {}", name));
    if (!topic) return fail(std::move(topic.error()));
    entity = std::move(*topic);
    return {};
  };
  auto done = make_one(presence_topic_, &rubicon_wire_Presence_desc, "rubicon_presence");
  if (done) done = make_one(interest_topic_, &rubicon_wire_Interest_desc, "rubicon_interests");
  if (done) done = make_one(frame_topic_, &rubicon_wire_Frame_desc, "rubicon_frames");
  if (done && (!bound_presences(presence_topic_.get(), stores_->presence_quota) ||
               !bound_interests(interest_topic_.get(), stores_->interest_quota)))
    return fail(ErrorCode::kIo, "DDS does not bound what it keeps of others");
  return done;
}

Result<void> DdsLink::make_readers() {
  unmatched_seen_ = 0;
  auto frames = make_qos();
  dds_qset_reliability(frames.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_history(frames.get(), DDS_HISTORY_KEEP_ALL, 0);
  dds_qset_resource_limits(frames.get(), kQueuedFrames, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  auto of_frames = group_in("subscriber of frames", {fmt::format("*.{}", hex_id(self_))}, true);
  if (!of_frames) return fail(std::move(of_frames.error()));
  frame_subscriber_ = std::move(*of_frames);
  auto of_all = group_in("subscriber of presence and interests", {"*"}, true);
  if (!of_all) return fail(std::move(of_all.error()));
  all_subscriber_ = std::move(*of_all);
  // The readers request no lease: that would hide components with a longer one. Each component has its own.
  const auto make_one = [](Entity& entity, const char* what, dds_entity_t answer) -> Result<void> {
    auto reader = made(answer, fmt::format("reader of {}", what));
    if (!reader) return fail(std::move(reader.error()));
    entity = std::move(*reader);
    return {};
  };
  const auto make_kept = [&](Entity& entity, const char* what, const Entity& topic, Signal::Source source) {
    return make_one(
        entity, what,
        dds_create_reader(all_subscriber_.get(), topic.get(), make_kept_qos().get(), signal_.listener(source)));
  };
  auto done = make_one(
      frame_reader_, "frames",
      dds_create_reader(frame_subscriber_.get(), frame_topic_.get(), frames.get(), signal_.listener(Signal::kFrames)));
  if (done) done = make_kept(interest_reader_, "interests", interest_topic_, Signal::kInterests);
  if (done) done = make_kept(presence_reader_, "presence", presence_topic_, Signal::kPresence);
  return done;
}

/// A publisher or a subscriber.
Result<Entity> DdsLink::group_in(const std::string& what, const std::vector<std::string>& partitions,
                                 bool of_readers) const {
  std::vector<const char*> names;
  for (const auto& one : partitions) names.push_back(one.c_str());
  auto qos = make_qos();
  dds_qset_partition(qos.get(), static_cast<std::uint32_t>(names.size()), names.data());
  return made(of_readers ? dds_create_subscriber(participant_.get(), qos.get(), nullptr)
                         : dds_create_publisher(participant_.get(), qos.get(), nullptr),
              what);
}

Result<void> DdsLink::make_writers() {
  const auto make_one = [this](Entity& publisher, Entity& entity, const std::string& what, const Entity& topic,
                               const Qos& with, const std::vector<std::string>& partitions) -> Result<void> {
    auto group = group_in("publisher of " + what, partitions, false);
    if (!group) return fail(std::move(group.error()));
    auto writer = made(dds_create_writer(group->get(), topic.get(), with.get(), nullptr), "writer of " + what);
    if (!writer) return fail(std::move(writer.error()));
    publisher = std::move(*group);
    entity = std::move(*writer);
    return {};
  };
  const auto own = hex_id(self_);
  auto qos = make_kept_qos();
  dds_qset_writer_data_lifecycle(qos.get(), false);  // a crash must not look like an orderly leave
  auto done = make_one(interest_publisher_, interest_writer_, "interests", interest_topic_, qos, {own});
  if (!done) return done;
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, lease_.count());
  // Components of version 1 read in the default partition only: they should see that another version is there.
  return make_one(presence_publisher_, presence_writer_, "presence", presence_topic_, qos, {own, ""});
}

bool DdsLink::write_presence() {
  rubicon_wire_Presence presence{};
  presence.id = number(self_);
  presence.incarnation = incarnation_;
  presence.version = kProtocolVersion;
  presence.host = host_.data();
  presence.summary = summary_.data();
  presence_unwritten_ = dds_write(presence_writer_.get(), &presence) != DDS_RETCODE_OK;
  return !presence_unwritten_;
}

/// Announces that this component leaves, and forgets all others. Keeps entities that no listener used yet.
void DdsLink::leave() {
  if (!listener_) return;
  flush();  // what can still be sent
  listener_ = nullptr;
  flush_retry_.clear();
  forget_own();
  if (!participant_) {
    peers_.clear();
    return gone_.clear();
  }
  rubicon_wire_Presence presence{};
  presence.id = number(self_);
  presence.incarnation = incarnation_;
  presence.host = host_.data();
  presence.summary = summary_.data();
  dds_dispose(presence_writer_.get(), &presence);
  dds_unregister_instance(presence_writer_.get(), &presence);
  await_receivers();
  forget_others();
  peers_.clear();
  gone_.clear();
  delete_entities();
}

/// All but the participant and the topics.
void DdsLink::delete_entities() {
  for (auto* entity : {&presence_reader_, &interest_reader_, &all_subscriber_, &frame_reader_, &frame_subscriber_,
                       &interest_writer_, &interest_publisher_, &presence_writer_, &presence_publisher_}) {
    entity->reset();
  }
}

/// What DDS reported of them; peers_ stays.
void DdsLink::forget_others() {
  for (const auto& [id, peer] : peers_) {
    if (peer.is_up()) policy_->peer_down(id);
  }
  id_conflicts_.begin(0);
  interests_.clear();
  participants_.clear();
  writers_.clear();
  early_frames_.clear();
  early_timer_.cancel();
  early_sets_.clear();
  early_sets_timer_.cancel();
}

void DdsLink::forget_own() {
  slots_.clear();
  slot_of_.clear();
  free_slots_.clear();
  unwritten_slots_.clear();
}

Channel* DdsLink::channel_to(OwnerId id, Peer& peer) {
  if (peer.channel) return peer.channel.get();
  auto channel = Channel::make({self_, id, incarnation_, peer.incarnation}, participant_.get(), frame_topic_.get(),
                               signal_.listener(Signal::kWriter));
  if (!channel) {
    warn("channel", channel.error().text);
    return nullptr;
  }
  peer.channel = std::move(*channel);
  return peer.channel.get();
}

Peer* DdsLink::find_up(OwnerId id) {
  const auto found = peers_.find(id);
  return found == peers_.end() || !found->second.is_up() ? nullptr : &found->second;
}

bool DdsLink::publish(OwnerId subscriber, std::span<const Change> changes) {
  auto* peer = find_up(subscriber);
  if (!peer) return true;  // no receiver: dropped
  auto* channel = channel_to(subscriber, *peer);
  if (!channel || channel->waiting() > kMaxWaitingBytes) return false;
  distant::FrameWriter entries;
  for (const auto& change : changes) {
    if (entries.size() > 0 && entries.size() + size_of(change) > Channel::kFrameBytes) channel->add(entries.take());
    entries.add(change);
  }
  if (entries.size() > 0) channel->add(entries.take());
  flush(*peer);
  return true;
}

Channel::State DdsLink::write_frames(Peer& peer) {
  return peer.channel->flush(scheduler_.now(), [&](bool asks) { return peer.ages.next(shared_.since_boot(), asks); });
}

/// To be called by publish(), which brings all changes of a turn at once.
void DdsLink::flush(Peer& peer) {
  const auto state = write_frames(peer);
  if (state == Channel::State::kFull) retry_flush();
  if (state == Channel::State::kMore) flush_soon_.request();
}

Result<void> DdsLink::remote_set(const RemoteSet& set) {
  auto* peer = find_up(set.owner);
  if (!peer) return fail(ErrorCode::kNotFound, fmt::format("no component {} is present", number(set.owner)));
  auto* channel = channel_to(set.owner, *peer);
  if (!channel || channel->waiting() > kMaxSetsWaiting)
    return fail(ErrorCode::kBusy,
                fmt::format("component {} does not accept requests at the moment", number(set.owner)));
  channel->add(set, scheduler_.now());
  flush_soon_.request();
  return {};
}

/// Replies beyond the bound are dropped: a component that sends many requests and reads no replies loses them.
void DdsLink::reply(const Reply& reply) {
  auto* peer = find_up(reply.to);
  auto* channel = peer ? channel_to(reply.to, *peer) : nullptr;
  if (!channel) return;
  if (channel->waiting() > kMaxSetsWaiting)
    return warn("replies", fmt::format("component {} does not read its replies: some are dropped", number(reply.to)));
  channel->add(reply);
  flush_soon_.request();
}

void DdsLink::subscribe(const SubscriptionSpec& spec) {
  std::uint32_t number = static_cast<std::uint32_t>(slots_.size());
  if (const auto known = slot_of_.find(spec.id); known != slot_of_.end()) {
    number = known->second;
  } else if (!free_slots_.empty()) {
    number = *free_slots_.begin();
    free_slots_.erase(free_slots_.begin());
  }
  distant::FrameWriter content;
  content.add(spec);
  slots_[number] = content.take();
  slot_of_[spec.id] = number;
  unwritten_slots_.insert(number);
  flush_soon_.request();
}

void DdsLink::unsubscribe(std::uint32_t id) {
  const auto found = slot_of_.find(id);
  if (found == slot_of_.end()) return;
  slots_[found->second].clear();
  unwritten_slots_.insert(found->second);
  slot_of_.erase(found);
  flush_soon_.request();
}

void DdsLink::repeat_interests() {
  for (const auto& [number, content] : slots_) {
    if (!content.empty()) unwritten_slots_.insert(number);
  }
  flush_soon_.request();
}

bool DdsLink::write_slot(std::uint32_t number, const Bytes& content) {
  const auto interest = interest_of(self_, incarnation_, number, content);
  if (!content.empty()) return dds_write(interest_writer_.get(), &interest) == DDS_RETCODE_OK;
  const auto gone = dds_dispose(interest_writer_.get(), &interest);
  if (gone != DDS_RETCODE_OK) return false;
  dds_unregister_instance(interest_writer_.get(), &interest);
  return true;
}

/// False: DDS accepts nothing at the moment.
bool DdsLink::flush_slots() {
  while (!unwritten_slots_.empty()) {
    const auto number = *unwritten_slots_.begin();
    const auto& content = slots_[number];
    if (!write_slot(number, content)) return false;
    unwritten_slots_.erase(unwritten_slots_.begin());
    if (content.empty()) free_slots_.insert(number);
  }
  return true;
}

void DdsLink::retry_flush() {
  flush_retry_.advance_to(scheduler_.now() + kRetry);
}

void DdsLink::flush() {
  if (!listener_ || !participant_) return;
  bool full = !flush_slots(), more = false;
  if (presence_unwritten_) full |= !write_presence();
  for (auto& [id, peer] : peers_) {
    if (!peer.channel) continue;
    const auto state = write_frames(peer);
    full |= state == Channel::State::kFull;
    more |= state == Channel::State::kMore;
  }
  if (more) flush_soon_.request();
  if (full) retry_flush();
}

void DdsLink::describe(std::string summary) {
  if (summary == summary_) return;
  summary_ = std::move(summary);
  presence_unwritten_ = true;
  flush_soon_.request();
}

std::vector<OwnerId> DdsLink::peers() const {
  std::vector<OwnerId> present;
  for (const auto& [id, peer] : peers_) {
    if (peer.is_up()) present.push_back(id);
  }
  return present;
}

}  // namespace rubicon::tuples::dds
