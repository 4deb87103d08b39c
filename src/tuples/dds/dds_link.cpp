#include "tuples/dds/dds_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/dds/host.h"
#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

/// What may wait for one component before publish() and remote_set() say that there is no room.
constexpr std::size_t kMaxWaiting = 512 * 1024;
constexpr std::size_t kMaxSetsWaiting = 32 * 1024 * 1024;
/// Between attempts to write to who takes nothing.
constexpr Duration kRetry = std::chrono::milliseconds(1);

rubicon_wire_Interest interest_of(OwnerId id, std::uint64_t incarnation, std::uint32_t slot, const Bytes& content) {
  rubicon_wire_Interest interest{};
  interest.subscriber = number(id);
  interest.incarnation = incarnation;
  interest.slot = slot;
  interest.content._maximum = interest.content._length = static_cast<std::uint32_t>(content.size());
  interest.content._buffer = const_cast<std::uint8_t*>(content.data());  // written, never changed
  return interest;
}

std::size_t size_of(const Change& change) {
  return change.tuple.key.size() + change.tuple.value.size() + change.tuple.media_type.size() + 64;
}

}  // namespace

DdsLink::DdsLink(OwnerId self, Entity participant, const DdsOptions& options, Scheduler& scheduler,
                 DdsEcology::Post post, std::function<void()> displaced, std::shared_ptr<Appearances> appearances,
                 base::LogSink& log)
    : self_(self),
      scheduler_(scheduler),
      log_(log, "dds"),
      lease_(options.lease),
      trusts_others_(options.trust_lan),
      host_(host_id("host")),
      displaced_(std::move(displaced)),
      appearances_(std::move(appearances)),
      signal_(std::move(post), [this](unsigned sources) { drain(sources); }),
      participant_(std::move(participant)) {}

DdsLink::~DdsLink() {
  leave();
}

void DdsLink::warn(const std::string& subject, const std::string& text) {
  if (log_limit_.allow(subject, scheduler_.now())) log_.warning(text);
}

void DdsLink::attach(LinkListener* listener) {
  leave();
  listener_ = listener;
  if (!listener) return;
  const auto since = scheduler_.wall_now().time_since_epoch().count();
  incarnation_ = std::max(static_cast<std::uint64_t>(since), incarnation_ + 1);
  if (auto entered = enter(); !entered) log_.error(entered.error().text);
}

/// Readers first: whoever sees us can reach us.
Result<void> DdsLink::enter() {
  if (auto made_ones = make_readers(); !made_ones) return made_ones;
  auto qos = make_kept_qos();
  dds_qset_writer_data_lifecycle(qos.get(), false);  // a crash must not look like a farewell
  auto interests = made(dds_create_writer(participant_.get(), interest_topic_.get(), qos.get(), nullptr), "interests");
  if (!interests) return fail(std::move(interests.error()));
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, lease_.count());
  auto presence = made(dds_create_writer(participant_.get(), presence_topic_.get(), qos.get(), nullptr), "presence");
  if (!presence) return fail(std::move(presence.error()));
  interest_writer_ = std::move(*interests);
  presence_writer_ = std::move(*presence);
  if (!write_presence()) return fail(ErrorCode::kIo, "DDS: presence cannot be written");
  return {};
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

/// Says farewell, and forgets everybody.
void DdsLink::leave() {
  flush_timer_.cancel();
  flush_at_ = SteadyTime::max();
  if (presence_writer_) {
    flush();  // what can still be told
    rubicon_wire_Presence presence{};
    presence.id = number(self_);
    presence.incarnation = incarnation_;
    presence.host = host_.data();
    presence.summary = summary_.data();
    dds_dispose(presence_writer_.get(), &presence);
    dds_unregister_instance(presence_writer_.get(), &presence);
  }
  listener_ = nullptr;
  peers_.clear();
  for (auto* entity : {&presence_reader_, &interest_reader_, &frame_reader_, &frame_subscriber_, &interest_writer_,
                       &presence_writer_}) {
    entity->reset();
  }
  slots_.clear();
  slot_of_.clear();
  free_slots_.clear();
  unwritten_slots_.clear();
  publications_.clear();
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
  if (!peer) return true;  // nobody is there to take them
  auto* channel = channel_to(subscriber, *peer);
  if (!channel || channel->waiting() > kMaxWaiting) return false;
  FrameWriter entries;
  for (const auto& change : changes) {
    if (entries.size() > 0 && entries.size() + size_of(change) > Channel::kFrameBytes) channel->add(entries.take());
    entries.add(change);
  }
  if (entries.size() > 0) channel->add(entries.take());
  flush(*channel);
  return true;
}

/// At once: what a space publishes is all that its turn brought.
void DdsLink::flush(Channel& channel) {
  const auto state = channel.flush(scheduler_.now());
  if (state != Channel::State::kEmpty) ask_flush(state == Channel::State::kFull ? kRetry : Duration(0));
}

Result<void> DdsLink::remote_set(const RemoteSet& wish) {
  auto* peer = find_up(wish.owner);
  if (!peer) return fail(ErrorCode::kNotFound, fmt::format("no component {} in the ecology", number(wish.owner)));
  auto* channel = channel_to(wish.owner, *peer);
  if (!channel || channel->waiting() > kMaxSetsWaiting)
    return fail(ErrorCode::kBusy, fmt::format("component {} takes nothing at the moment", number(wish.owner)));
  channel->add(wish, scheduler_.now());
  ask_flush(Duration(0));
  return {};
}

/// Not bounded by itself: who sets much and takes no replies is held up by its own channel's bound of sets under way.
void DdsLink::reply(const Reply& reply) {
  auto* peer = find_up(reply.to);
  auto* channel = peer ? channel_to(reply.to, *peer) : nullptr;
  if (!channel) return;
  if (channel->waiting() > kMaxSetsWaiting)
    return warn("replies", fmt::format("component {} takes no replies: some are dropped", number(reply.to)));
  channel->add(reply);
  ask_flush(Duration(0));
}

void DdsLink::subscribe(const SubscriptionSpec& spec) {
  std::uint32_t number = static_cast<std::uint32_t>(slots_.size());
  if (const auto known = slot_of_.find(spec.id); known != slot_of_.end()) {
    number = known->second;
  } else if (!free_slots_.empty()) {
    number = *free_slots_.begin();
    free_slots_.erase(free_slots_.begin());
  }
  FrameWriter content;
  content.add(spec);
  slots_[number] = content.take();
  slot_of_[spec.id] = number;
  unwritten_slots_.insert(number);
  ask_flush(Duration(0));
}

void DdsLink::unsubscribe(std::uint32_t id) {
  const auto found = slot_of_.find(id);
  if (found == slot_of_.end()) return;
  slots_[found->second].clear();
  unwritten_slots_.insert(found->second);
  slot_of_.erase(found);
  ask_flush(Duration(0));
}

bool DdsLink::write_slot(std::uint32_t number, const Bytes& content) {
  const auto interest = interest_of(self_, incarnation_, number, content);
  if (!content.empty()) return dds_write(interest_writer_.get(), &interest) == DDS_RETCODE_OK;
  const auto gone = dds_dispose(interest_writer_.get(), &interest);
  if (gone != DDS_RETCODE_OK) return false;
  dds_unregister_instance(interest_writer_.get(), &interest);
  return true;
}

/// False: DDS takes nothing now.
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

/// One call a turn, so that what a turn brings goes together.
void DdsLink::ask_flush(Duration within) {
  if (within == Duration(0)) return ask_flush();
  const auto when = scheduler_.now() + within;
  if (when >= flush_at_) return;
  flush_at_ = when;
  flush_timer_ = scheduler_.at(when, [this] {
    flush_at_ = SteadyTime::max();
    flush();
  });
}

void DdsLink::ask_flush() {
  if (std::exchange(flush_posted_, true)) return;
  scheduler_.post([this, door = std::weak_ptr(door_)] {
    if (door.expired()) return;
    flush_posted_ = false;
    flush();
  });
}

void DdsLink::flush() {
  if (!presence_writer_) return;
  const auto now = scheduler_.now();
  bool full = !flush_slots(), more = false;
  if (presence_unwritten_) full |= !write_presence();
  for (auto& [id, peer] : peers_) {
    if (!peer.channel) continue;
    const auto state = peer.channel->flush(now);
    full |= state == Channel::State::kFull;
    more |= state == Channel::State::kMore;
  }
  if (listener_ && more) ask_flush(Duration(0));
  if (listener_ && full) ask_flush(kRetry);
}

void DdsLink::describe(std::string summary) {
  if (summary == summary_) return;
  summary_ = std::move(summary);
  presence_unwritten_ = true;
  ask_flush(Duration(0));
}

std::vector<OwnerId> DdsLink::peers() const {
  std::vector<OwnerId> there;
  for (const auto& [id, peer] : peers_) {
    if (peer.is_up()) there.push_back(id);
  }
  return there;
}

}  // namespace rubicon::tuples::dds
