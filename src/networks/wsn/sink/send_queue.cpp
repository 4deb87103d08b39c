#include "networks/wsn/sink/send_queue.h"

#include <fmt/format.h>

#include <utility>

#include "base/assert.h"
#include "motes/mote_packet.h"

namespace rubicon::networks::wsn::sink {

std::string_view to_string(Lane lane) {
  switch (lane) {
    case Lane::kCommand: return "command";
    case Lane::kClient: return "client";
    case Lane::kSampling: return "sampling";
    case Lane::kProbe: break;
  }
  return "probe";
}

SendQueue::SendQueue(Scheduler& scheduler, std::size_t lane_size, Callbacks callbacks)
    : scheduler_(scheduler),
      lane_size_(lane_size),
      callbacks_(std::move(callbacks)),
      packets_(
          scheduler, kLanes, [this](Outgoing packet) { expired(std::move(packet)); }, [this] { notify_room(); }),
      ready_(scheduler, [this] { callbacks_.ready(); }) {
  RUBICON_ASSERT(lane_size > 0);
}

Result<void> SendQueue::push(Outgoing packet) {
  RUBICON_ASSERT(!packet.packet.empty() && packet.packet.size() <= motes::kMaxPacket);
  const auto lane = index_of(packet.lane);
  if (packets_.size(lane) >= lane_size_) {
    lanes_.at(lane).refused = true;
    return fail(ErrorCode::kBusy, fmt::format("the queue to the sink is full: {} packets wait in lane {}",
                                              packets_.size(lane), to_string(packet.lane)));
  }
  if (packets_.empty(lane)) lanes_.at(lane).passed = 0;
  packets_.push_back(lane, std::move(packet));
  ready_.request();
  return {};
}

/// The best lane with packets, unless another one was passed over too often.
std::optional<std::size_t> SendQueue::next_lane() const {
  std::optional<std::size_t> best;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (packets_.empty(lane)) continue;
    if (lanes_.at(lane).passed >= kMaxPassed) return lane;
    if (!best) best = lane;
  }
  return best;
}

void SendQueue::count_passed(std::size_t taken) {
  for (std::size_t lane = taken + 1; lane < kLanes; ++lane) {
    if (!packets_.empty(lane)) ++lanes_.at(lane).passed;
  }
}

std::optional<Outgoing> SendQueue::take() {
  std::optional<Outgoing> taken;
  while (const auto lane = taken ? std::nullopt : next_lane()) {
    auto packet = packets_.pop_front(*lane);
    if (packet.expires <= scheduler_.now()) {
      expired(std::move(packet));
      continue;
    }
    taken = std::move(packet);
    lanes_.at(*lane).passed = 0;
    count_passed(*lane);
  }
  notify_room();
  return taken;
}

void SendQueue::put_back(Outgoing packet) {
  packets_.push_front(index_of(packet.lane), std::move(packet));
}

void SendQueue::expired(Outgoing packet) {
  ++expired_;
  report(std::move(packet.done), SendResult::kExpired);
}

void SendQueue::report(SendCallback done, SendResult result) {
  if (done) lifetime_.post(scheduler_, [done = std::move(done), result] { done(result); });
}

void SendQueue::notify_room() {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (packets_.size(lane) >= lane_size_ || !std::exchange(lanes_.at(lane).refused, false)) continue;
    lifetime_.post(scheduler_, [this, lane] { callbacks_.room(static_cast<Lane>(lane)); });
  }
}

void SendQueue::count(std::map<std::string, std::uint64_t>& into) const {
  into["expired"] = expired_;
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    into[fmt::format("waiting-{}", to_string(static_cast<Lane>(lane)))] = packets_.size(lane);
}

}  // namespace rubicon::networks::wsn::sink
