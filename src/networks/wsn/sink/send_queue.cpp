#include "networks/wsn/sink/send_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "motes/mote_packet.h"

namespace rubicon::networks::wsn::sink {

namespace {

/// Expired packets are looked for at most this often.
constexpr Duration kExpiryStep = std::chrono::milliseconds(10);

}  // namespace

std::string_view to_string(Lane lane) {
  switch (lane) {
    case Lane::kCommand: return "command";
    case Lane::kClient: return "client";
    case Lane::kSampling: return "sampling";
    case Lane::kProbe: break;
  }
  return "probe";
}

SendQueue::SendQueue(Scheduler& scheduler, std::size_t lane_size, Calls calls)
    : scheduler_(scheduler), lane_size_(lane_size), calls_(std::move(calls)) {
  RUBICON_ASSERT(lane_size > 0);
}

SendQueue::~SendQueue() {
  *alive_ = false;
}

Result<void> SendQueue::push(Outgoing packet) {
  RUBICON_ASSERT(!packet.packet.empty() && packet.packet.size() <= motes::kMaxPacket);
  auto& lane = lanes_.at(static_cast<std::size_t>(packet.lane));
  if (lane.packets.size() >= lane_size_) {
    lane.refused = true;
    return fail(ErrorCode::kBusy,
                fmt::format("{} packets wait for the sink already ({})", lane.packets.size(), to_string(packet.lane)));
  }
  if (lane.packets.empty()) lane.passed = 0;
  watch(packet.expires);
  lane.packets.push_back(std::move(packet));
  tell_ready();
  return {};
}

void SendQueue::tell_ready() {
  if (std::exchange(ready_asked_, true)) return;
  scheduler_.post([this, alive = alive_] {
    if (!*alive) return;
    ready_asked_ = false;
    calls_.ready();
  });
}

/// The best lane, unless another one was passed by too often.
SendQueue::Waiting* SendQueue::next() {
  const auto waits = [](const Waiting& lane) { return !lane.packets.empty(); };
  const auto passed = [&](const Waiting& lane) { return waits(lane) && lane.passed >= kPatience; };
  auto* found = std::find_if(lanes_.begin(), lanes_.end(), passed);
  if (found == lanes_.end()) found = std::find_if(lanes_.begin(), lanes_.end(), waits);
  return found == lanes_.end() ? nullptr : &*found;
}

void SendQueue::count_passed(const Waiting& taken) {
  for (auto* worse = lanes_.data() + (&taken - lanes_.data()) + 1; worse != lanes_.data() + kLanes; ++worse) {
    if (!worse->packets.empty()) ++worse->passed;
  }
}

std::optional<Outgoing> SendQueue::take() {
  std::optional<Outgoing> packet;
  while (Waiting* const lane = packet ? nullptr : next()) {
    packet = std::move(lane->packets.front());
    lane->packets.pop_front();
    if (packet->expires <= scheduler_.now()) {
      ++expired_;
      report(std::move(packet->done), SendResult::kExpired);
      packet.reset();
      continue;
    }
    lane->passed = 0;
    count_passed(*lane);
  }
  tell_room();
  return packet;
}

void SendQueue::put_back(Outgoing packet) {
  watch(packet.expires);
  auto& lane = lanes_.at(static_cast<std::size_t>(packet.lane));
  lane.packets.push_front(std::move(packet));
}

void SendQueue::report(SendCallback done, SendResult what) {
  if (!done) return;
  scheduler_.post([done = std::move(done), what, alive = alive_] {
    if (*alive) done(what);
  });
}

void SendQueue::tell_room() {
  for (auto& lane : lanes_) {
    if (lane.packets.size() >= lane_size_ || !std::exchange(lane.refused, false)) continue;
    scheduler_.post([this, which = static_cast<Lane>(&lane - lanes_.data()), alive = alive_] {
      if (*alive) calls_.room(which);
    });
  }
}

void SendQueue::watch(SteadyTime expires) {
  if (expires >= next_expiry_) return;
  next_expiry_ = expires;
  expiry_ = scheduler_.at(expires, [this] { expire(); });
}

void SendQueue::expire_in(Waiting& lane, SteadyTime now, SteadyTime& next) {
  std::erase_if(lane.packets, [&](Outgoing& packet) {
    if (packet.expires > now) {
      next = std::min(next, packet.expires);
      return false;
    }
    ++expired_;
    report(std::move(packet.done), SendResult::kExpired);
    return true;
  });
}

void SendQueue::expire() {
  const auto now = scheduler_.now();
  auto next = SteadyTime::max();
  for (auto& lane : lanes_) expire_in(lane, now, next);
  next_expiry_ = SteadyTime::max();
  if (next != SteadyTime::max()) watch(std::max(next, now + kExpiryStep));
  tell_room();
}

std::size_t SendQueue::waiting(Lane lane) const {
  return lanes_.at(static_cast<std::size_t>(lane)).packets.size();
}

void SendQueue::count(std::map<std::string, std::uint64_t>& into) const {
  into["expired"] = expired_;
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    into[fmt::format("waiting-{}", to_string(static_cast<Lane>(lane)))] = lanes_.at(lane).packets.size();
}

}  // namespace rubicon::networks::wsn::sink
