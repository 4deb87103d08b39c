#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <system_error>
#include <thread>

#include "tuples/dds/dds_link.h"
#include "tuples/dds/take_samples.h"
#include "tuples/host_policy.h"
#include "tuples/member_policy.h"
#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

/// How long a component that was lost may be away, beyond the lease, until what it was asked for is refused.
constexpr Duration kReturn = std::chrono::seconds(5);
/// Participants that were refused because they are not known: how many are looked at, for how long, how often.
constexpr std::size_t kMaxUnknown = 64;
constexpr Duration kUnknown = std::chrono::minutes(10);
constexpr Duration kLookAtUnknown = std::chrono::seconds(5);
/// A thread is missing on a host that is short of memory, which may be over soon.
constexpr int kThreadTries = 50;
constexpr int kLongDeletionMs = 10'000;

}  // namespace

/// nullptr: the writer is gone, and its origin was not asked before.
const Writer* DdsLink::origin_of(dds_entity_t reader, dds_instance_handle_t publication) {
  auto* writer = writers_.find(reader, publication);
  if (writer && identities_ && !writer->member) writer->member = identities_->who(prefix_of(writer->participant));
  return writer;
}

PeerIdentity DdsLink::identity_of(OwnerId id, std::uint64_t incarnation, const Peer::Start& start) const {
  PeerIdentity identity{id, incarnation, start.host, start.member};
  identity.own_process = identities_ && identities_->is_own(prefix_of(start.participant));
  return identity;
}

/// Whether the writer of a frame may speak for its source.
bool DdsLink::may_use(const Writer& writer, OwnerId source) {
  if (writer.member && writer.member->may_use(source)) return true;
  ++false_frames_;
  const auto who = writer.member ? text_of(*writer.member) : "a stranger";
  warn("false frames of " + who,
       fmt::format("{} sends frames in the name of component {}: dropped", who, number(source)));
  return false;
}

void DdsLink::report_false_claims() {
  const auto report = [this](Claims& claims, const char* what) {
    for (const auto& one : claims.take()) {
      if (participants_.is_banned(participant_of(one.participant))) continue;  // the log named it then
      if (one.member.empty()) note_unknown(one.participant);
      const auto who = one.member.empty() ? "a stranger" : one.member;
      warn(fmt::format("false {} of {}", what, who),
           fmt::format("{} writes {} in the name of component {}, an id that its certificate does not have: dropped",
                       who, what, number(one.id)));
    }
  };
  report(presence_claims_, "a presence");
  report(interest_claims_, "a subscription");
}

/// What it said is dropped for good, though it may have been the clock of this host that was wrong.
void DdsLink::note_unknown(const GuidPrefix& who) {
  if (unknown_.size() < kMaxUnknown) unknown_[who] = scheduler_.now() + kUnknown;
  if (!unknown_timer_.pending()) unknown_timer_ = scheduler_.after(kLookAtUnknown, [this] { look_at_unknown(); });
}

void DdsLink::look_at_unknown() {
  const auto now = scheduler_.now();
  const bool known_now = std::any_of(unknown_.begin(), unknown_.end(),
                                     [this](const auto& one) { return identities_->who(one.first) != nullptr; });
  if (known_now) unknown_.clear();
  std::erase_if(unknown_, [now](const auto& one) { return one.second <= now; });
  if (!unknown_.empty()) unknown_timer_ = scheduler_.after(kLookAtUnknown, [this] { look_at_unknown(); });
  if (known_now && shared_.known_later) shared_.known_later();
}

void DdsLink::each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const {
  if (!identities_) return;
  visit("dds-false-claims", presence_claims_.refused() + interest_claims_.refused() + false_frames_);
  visit("dds-refused-peers", shared_.refused_peers());
}

// -- what waits for a component that is away

void DdsLink::await(Peer& peer, PeerEvent event) {
  const bool may_return = event == PeerEvent::kLost;
  peer.awaited_until = may_return ? scheduler_.now() + lease_ + kReturn : SteadyTime{};
  if (!may_return) peer.unanswered.clear();
  if (may_return && !waiting_timer_.pending())
    waiting_timer_ = scheduler_.after(lease_ + kReturn, [this] { end_waiting(); });
}

/// Those that were awaited and did not return get no replies any more.
void DdsLink::end_waiting() {
  std::optional<SteadyTime> next;
  for (const auto& [id, peer] : peers_) {
    if (peer.is_up() || peer.awaited_until == SteadyTime{}) continue;
    if (peer.awaited_until <= scheduler_.now()) {
      replies_.drop(id);
    } else {
      next = std::min(next.value_or(peer.awaited_until), peer.awaited_until);
    }
  }
  if (next) waiting_timer_ = scheduler_.after(*next - scheduler_.now(), [this] { end_waiting(); });
  drop_gone_peers();
}

/// False: too much waits.
bool DdsLink::keep(Peer& peer, const RemoteSet& set) {
  return set.time_to_live > Duration(0) && peer.unanswered.add(set, scheduler_.now());
}

Result<void> DdsLink::hold(const RemoteSet& set) {
  const auto found = peers_.find(set.owner);
  if (!identities_ || found == peers_.end() || found->second.awaited_until <= scheduler_.now())
    return fail(ErrorCode::kNotFound, fmt::format("no component {} is present", number(set.owner)));
  if (keep(found->second, set)) return {};
  return fail(ErrorCode::kBusy,
              fmt::format("component {} is away, and too many requests wait for it", number(set.owner)));
}

/// If it is the same start as before, it has the numbers of the requests that it executed.
void DdsLink::send_again(OwnerId id, Peer& peer) {
  peer.awaited_until = {};
  if (std::exchange(peer.unanswered_by, peer.incarnation) != peer.incarnation) return peer.unanswered.clear();
  const auto& waiting = peer.unanswered.still_waiting(scheduler_.now());
  auto* channel = waiting.empty() ? nullptr : channel_to(id, peer);
  if (!channel) return;
  for (const auto& [request, one] : waiting) channel->add(one.set, one.since);
  flush_soon_.request();
}

void DdsLink::repeat_reply(Peer& peer, std::uint64_t request) {
  if (!identities_) return;
  auto reply = replies_.repeat(reading_from_, request);
  auto* channel = reply ? channel_to(reading_from_, peer) : nullptr;
  if (!channel) return;
  channel->add(std::move(*reply));
  flush_soon_.request();
}

// -- renewal

void DdsLink::suspend() {
  if (!participant_) return;
  if (listener_) take_frames();
  std::vector<OwnerId> there;
  std::vector<std::unique_ptr<Channel>> channels;
  for (auto& [id, peer] : peers_) {
    for (const auto& [incarnation, start] : peer.alive) starts_->note({id, incarnation, 0, false, {}});
    peer.alive.clear();
    channels.push_back(std::move(peer.channel));
    if (peer.is_up()) there.push_back(id);
  }
  delete_while_reading([&] {
    channels.clear();
    delete_entities();
    for (auto* entity : {&presence_topic_, &interest_topic_, &frame_topic_}) entity->reset();
  });
  for (const auto id : there) {
    if (auto* peer = listener_ ? find_up(id) : nullptr) peer_down(id, *peer, PeerEvent::kLost);
  }
  forget_others();
  participant_.reset();
}

namespace {

/// Without a thread if the system has none to give for a while; `meanwhile` runs before each further try.
template <class Call, class Meanwhile>
std::thread thread_of(Call call, Meanwhile meanwhile) {
  for (int i = 0; i < kThreadTries; ++i) {
    try {
      return std::thread(call);
    } catch (const std::system_error&) {
      meanwhile();
      dds_sleepfor(DDS_MSECS(1));
    }
  }
  return {};
}

}  // namespace

/// Cyclone deletes a writer when each of its threads has done what it was doing. One that waits for room in the reader
/// of frames has not, so the loop takes them meanwhile. What is taken here is sent again.
void DdsLink::delete_while_reading(const std::function<void()>& remove) const {
  const auto reader = frame_reader_.get();
  const auto read = [reader] { take<rubicon_wire_Frame>(reader, SIZE_MAX, [](const auto&, const auto&) {}); };
  std::atomic<bool> done{false};
  auto remover = thread_of(
      [&] {
        remove();
        done = true;
      },
      read);
  if (!remover.joinable()) {
    log_.error("no thread can be made to leave the domain: this may take long while others send");
    return remove();
  }
  for (int waited = 0; !done; ++waited) {
    read();
    dds_sleepfor(DDS_MSECS(1));
    if (waited == kLongDeletionMs) log_.error("leaving the domain takes long: DDS does not delete the endpoints");
  }
  remover.join();
}

/// A start before the clock of this host was set counts from when it was. The carrier knows its stand-ins by their
/// start.
void DdsLink::correct_start() {
  const auto now = static_cast<std::uint64_t>(scheduler_.wall_now().time_since_epoch().count());
  if (incarnation_ < HostPolicy::kEarliest && carrier_of(host_) == model::kNoOwner)
    incarnation_ = std::max(now, incarnation_);
}

Result<void> DdsLink::resume(Entity participant) {
  participant_ = std::move(participant);
  if (auto done = make_entities(); !done) return done;
  if (!listener_) return {};
  correct_start();
  id_conflicts_.begin(incarnation_);
  for (const auto& [number, content] : slots_) {
    if (!content.empty()) unwritten_slots_.insert(number);
  }
  revoked_unwritten_ = identities_ != nullptr;
  if (!write_presence()) retry_flush();
  flush_soon_.request();
  for (const auto source : {Signal::kPresence, Signal::kInterests, Signal::kFrames}) signal_.raise(source);
  return {};
}

// -- revocation

void DdsLink::hear_revoked(const HeardRevoked& lists) {
  if (!identities_) return;
  for (const auto& [member, list] : lists) {
    if (listener_ && shared_.heard_revoked) shared_.heard_revoked(member, list);
  }
}

bool DdsLink::write_revoked() {
  const auto list = identities_->revoked();
  rubicon_wire_Interest interest{};
  interest.subscriber = number(self_);
  interest.incarnation = incarnation_;
  interest.slot = kRevokedSlot;
  interest.content._maximum = interest.content._length = static_cast<std::uint32_t>(list.size());
  interest.content._buffer = reinterpret_cast<std::uint8_t*>(const_cast<char*>(list.data()));  // DDS only reads it
  revoked_unwritten_ = !list.empty() && dds_write(interest_writer_.get(), &interest) != DDS_RETCODE_OK;
  return !revoked_unwritten_;
}

bool DdsLink::renounce() {
  if (!listener_ || !participant_) return false;
  writers_.forget_members();
  const auto is_gone = [this](const Peer::Start& one) { return !identities_->who(prefix_of(one.participant)); };
  std::map<Participant, std::string> gone;
  std::vector<OwnerId> ids;
  for (auto& [id, peer] : peers_) {
    for (auto& [incarnation, start] : peer.alive) {
      if (start.heir && is_gone(*start.heir)) start.heir.reset();
      if (!start.member || !is_gone(start)) continue;
      gone.emplace(start.participant, text_of(*start.member));
      ids.push_back(id);
    }
  }
  for (const auto& [participant, name] : gone) {
    log_.warning(fmt::format("{} is no member any more: its components are lost", name));
    shut_out(participant);
    if (!listener_) return true;
  }
  for (const auto id : ids) {  // they are not awaited
    if (const auto peer = peers_.find(id); peer != peers_.end() && !peer->second.is_up())
      await(peer->second, PeerEvent::kLeft);
  }
  revoked_unwritten_ = true;
  flush_soon_.request();
  return !gone.empty();
}

// -- readers of what is sent

/// They belong to the member that has the id of the destination.
Channel::MayRead DdsLink::readers_of(OwnerId target) {
  if (!identities_) return {};
  return [this, target](const GuidPrefix& participant) {
    const auto member = identities_->who(participant);
    if (member && member->may_use(target)) return true;
    const auto who = member ? text_of(*member) : "a stranger";
    warn("foreign readers of " + who,
         fmt::format("{} reads what is for component {}: nothing is sent", who, number(target)));
    return false;
  };
}

}  // namespace rubicon::tuples::dds
