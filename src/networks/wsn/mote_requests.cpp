#include "networks/wsn/mote_requests.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "base/assert.h"

namespace rubicon::networks::wsn {

namespace {

/// The programs of the motes use it for "no room" (wsn.md 5).
constexpr std::uint16_t kNoSequence = 0xffff;
/// Until the next try to send a repetition for which the lane was full.
constexpr Duration kBusyPause = std::chrono::milliseconds(200);

}  // namespace

MoteRequests::MoteRequests(Scheduler& scheduler, SendCall send, std::function<void()> unanswered)
    : scheduler_(scheduler),
      send_(std::move(send)),
      unanswered_attempt_(std::move(unanswered)),
      rng_(static_cast<std::uint_fast32_t>(scheduler.wall_now().time_since_epoch().count())) {}

std::uint16_t MoteRequests::free_sequence(std::uint16_t mote) {
  for (;;) {
    const auto sequence = static_cast<std::uint16_t>(rng_());
    if (sequence != kNoSequence && !pending_.contains({mote, sequence})) return sequence;
  }
}

Result<void> MoteRequests::send(MoteRequest request) {
  RUBICON_ASSERT(request.record.size() <= kMaxRecord);
  if (pending_.size() >= kMaxPending)
    return fail(ErrorCode::kBusy, fmt::format("{} messages to motes are pending", pending_.size()));
  const auto mote = request.header.destination_mote;
  const Key key{mote, request.sequence ? *request.sequence : free_sequence(mote)};
  if (pending_.contains(key))
    return fail(ErrorCode::kDuplicate,
                fmt::format("a message with sequence number {} to mote {} is pending", key.second, mote));
  const auto subject = request.subject;
  Pending& pending = pending_[key];
  pending.expires = scheduler_.now() + request.time_to_live;
  pending.request = std::move(request);
  auto transmitted = transmit(key, pending);
  if (!transmitted) pending_.erase(key);
  if (transmitted && subject) supersede(key, *subject);
  return transmitted;
}

void MoteRequests::supersede(const Key& by, std::uint16_t subject) {
  std::vector<Key> older;
  for (auto one = pending_.lower_bound({by.first, 0}); one != pending_.end() && one->first.first == by.first; ++one) {
    if (one->first != by && one->second.request.subject == subject) older.push_back(one->first);
  }
  for (const Key& key : older) {
    lifetime_.post(scheduler_, [this, key, attempt = pending_.at(key).attempt] {
      const auto found = pending_.find(key);
      if (found != pending_.end() && found->second.attempt == attempt) end(key, DeliveryResult::kSuperseded);
    });
  }
}

Result<void> MoteRequests::transmit(const Key& key, Pending& pending) {
  auto& request = pending.request;
  auto message = request.header;
  message.sequence = key.second;
  message.record = request.record;
  const bool repeatable = request.attempts > 1 || request.idempotent;
  sink::Outgoing out{motes::packet_of(message), request.lane, pending.expires, repeatable, {}};
  out.done =
      lifetime_.guard([this, key, attempt = ++last_attempt_](sink::SendResult result) { sent(key, attempt, result); });
  pending.attempt = last_attempt_;
  auto queued = send_(std::move(out));
  if (queued) ++pending.tries;
  return queued;
}

void MoteRequests::sent(const Key& key, std::uint64_t attempt, sink::SendResult result) {
  using sink::SendResult;
  const auto found = pending_.find(key);
  if (found == pending_.end() || found->second.attempt != attempt) return;  // the mote answered before
  auto& pending = found->second;
  if (result == SendResult::kRefused) return end(key, DeliveryResult::kRefused);
  if (result == SendResult::kExpired)
    return end(key, pending.reached_sink ? DeliveryResult::kNoAnswer : DeliveryResult::kExpired);
  const bool acknowledged = result == SendResult::kAcknowledged;
  if (!acknowledged && pending.request.attempts == 1) return end(key, DeliveryResult::kSinkSilent);
  pending.reached_sink = pending.reached_sink || acknowledged;
  if (pending.request.header.reliable == 0)
    return end(key, acknowledged ? DeliveryResult::kAcknowledged : DeliveryResult::kSinkSilent);
  pending.timeout = scheduler_.after(kAckTimeout, [this, key] { retry(key); });
}

void MoteRequests::retry(Key key) {
  auto& pending = pending_.at(key);
  if (pending.reached_sink && unanswered_attempt_) unanswered_attempt_();
  const bool over = pending.tries >= pending.request.attempts || scheduler_.now() >= pending.expires;
  if (over) return end(key, pending.reached_sink ? DeliveryResult::kNoAnswer : DeliveryResult::kSinkSilent);
  if (transmit(key, pending)) return;
  pending.timeout = scheduler_.after(kBusyPause, [this, key] { retry(key); });
}

bool MoteRequests::acknowledged(const motes::HeardAck& ack) {
  const Key key{ack.mote, ack.ack.sequence};
  const auto found = pending_.find(key);
  if (found == pending_.end() || found->second.request.header.reliable == 0) return false;
  end(key, ack.ack.status == 0 ? DeliveryResult::kAcknowledged : DeliveryResult::kRejected);
  return true;
}

void MoteRequests::end(Key key, DeliveryResult result) {
  auto ended = pending_.extract(key);
  if (result == DeliveryResult::kNoAnswer) ++unanswered_;
  if (auto done = std::move(ended.mapped().request.done)) done(result);
}

}  // namespace rubicon::networks::wsn
