#include "networks/wsn/mote_requests.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "base/assert.h"

namespace rubicon::networks::wsn {

namespace {

/// The motes' own programs take it for "no room" (wsn.md 5).
constexpr std::uint16_t kNoSequence = 0xffff;
/// When the lane is full, a repetition comes back.
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
  RUBICON_ASSERT(request.record.size() <= kLongestRecord);
  if (pending_.size() >= kMostPending)
    return fail(ErrorCode::kBusy, fmt::format("{} messages to motes wait already", pending_.size()));
  const auto mote = request.header.destination_mote;
  const Name name{mote, request.sequence ? *request.sequence : free_sequence(mote)};
  if (pending_.contains(name))
    return fail(ErrorCode::kDuplicate, fmt::format("a message {} to mote {} is under way", name.second, mote));
  const auto subject = request.subject;
  Pending& pending = pending_[name];
  pending.expires = scheduler_.now() + request.time_to_live;
  pending.request = std::move(request);
  auto put = this->put(name, pending);
  if (!put) pending_.erase(name);
  if (put && subject) supersede(name, *subject);
  return put;
}

void MoteRequests::supersede(const Name& by, std::uint16_t subject) {
  std::vector<Name> older;
  for (auto one = pending_.lower_bound({by.first, 0}); one != pending_.end() && one->first.first == by.first; ++one) {
    if (one->first != by && one->second.request.subject == subject) older.push_back(one->first);
  }
  for (const Name& name : older) {
    lifetime_.post(scheduler_, [this, name, attempt = pending_.at(name).attempt] {
      const auto found = pending_.find(name);
      if (found != pending_.end() && found->second.attempt == attempt) end(name, DeliveryResult::kSuperseded);
    });
  }
}

Result<void> MoteRequests::put(const Name& name, Pending& pending) {
  auto& request = pending.request;
  auto message = request.header;
  message.sequence = name.second;
  message.record = request.record;
  const bool repeatable = request.attempts > 1 || request.harmless;
  sink::Outgoing out{motes::packet_of(message), request.lane, pending.expires, repeatable, {}};
  out.done = lifetime_.guard(
      [this, name, attempt = ++last_attempt_](sink::SendResult outcome) { sent(name, attempt, outcome); });
  pending.attempt = last_attempt_;
  auto put = send_(std::move(out));
  if (put) ++pending.tries;
  return put;
}

void MoteRequests::sent(const Name& name, std::uint64_t attempt, sink::SendResult outcome) {
  const auto found = pending_.find(name);
  if (found == pending_.end() || found->second.attempt != attempt) return;  // the mote was faster
  auto& pending = found->second;
  if (outcome == sink::SendResult::kRefused) return end(name, DeliveryResult::kRefused);
  if (outcome == sink::SendResult::kExpired)
    return end(name, pending.left ? DeliveryResult::kNoAnswer : DeliveryResult::kExpired);
  if (outcome == sink::SendResult::kNotAcknowledged && pending.request.attempts == 1)
    return end(name, DeliveryResult::kSinkSilent);
  pending.left = pending.left || outcome == sink::SendResult::kAcknowledged;
  if (pending.request.header.reliable == 0)
    return end(
        name, outcome == sink::SendResult::kAcknowledged ? DeliveryResult::kAcknowledged : DeliveryResult::kSinkSilent);
  pending.patience = scheduler_.after(kPatience, [this, name] { again(name); });
}

void MoteRequests::again(Name name) {
  auto& pending = pending_.at(name);
  if (pending.left && unanswered_attempt_) unanswered_attempt_();
  const bool over = pending.tries >= pending.request.attempts || scheduler_.now() >= pending.expires;
  if (over) return end(name, pending.left ? DeliveryResult::kNoAnswer : DeliveryResult::kSinkSilent);
  if (put(name, pending)) return;
  pending.patience = scheduler_.after(kBusyPause, [this, name] { again(name); });
}

bool MoteRequests::heard(const motes::HeardAck& ack) {
  const Name name{ack.mote, ack.ack.sequence};
  const auto found = pending_.find(name);
  if (found == pending_.end() || found->second.request.header.reliable == 0) return false;
  end(name, ack.ack.status == 0 ? DeliveryResult::kAcknowledged : DeliveryResult::kRejected);
  return true;
}

void MoteRequests::end(Name name, DeliveryResult how) {
  auto ended = pending_.extract(name);
  if (how == DeliveryResult::kNoAnswer) ++unanswered_;
  if (auto done = std::move(ended.mapped().request.done)) done(how);
}

}  // namespace rubicon::networks::wsn
