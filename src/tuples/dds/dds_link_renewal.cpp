#include <atomic>
#include <system_error>
#include <thread>

#include "tuples/dds/dds_link.h"
#include "tuples/host_policy.h"
#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

/// A thread is missing on a host that is short of memory, which may be over soon.
constexpr int kThreadTries = 50;
constexpr int kLongDeletionMs = 10'000;

}  // namespace

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
/// of frames has not, so the loop takes them meanwhile.
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
  if (!write_presence()) retry_flush();
  flush_soon_.request();
  for (const auto source : {Signal::kPresence, Signal::kInterests, Signal::kFrames}) signal_.raise(source);
  return {};
}

}  // namespace rubicon::tuples::dds
