#include "networks/knx/line/telegram_queue.h"

#include <algorithm>
#include <utility>

#include "base/assert.h"

namespace rubicon::networks::knx::line {

namespace {

constexpr std::string_view kExpiredBefore = "it expired before it could be sent";
constexpr std::string_view kNoAnswer = "the line was lost before the interface acknowledged it";
constexpr std::size_t kRanks = 4;

/// System, urgent, normal, low (knx.md, section 8).
std::size_t rank(wire::Priority priority) {
  switch (priority) {
    case wire::Priority::kSystem: return 0;
    case wire::Priority::kUrgent: return 1;
    case wire::Priority::kNormal: return 2;
    case wire::Priority::kLow: break;
  }
  return 3;
}

}  // namespace

TelegramQueue::TelegramQueue(Scheduler& scheduler, Limits limits, std::function<void()> ready)
    : scheduler_(scheduler),
      limits_(limits),
      ready_(std::move(ready)),
      queues_(scheduler, 2 * kRanks, [this](Item item) { expired(std::move(item)); }),
      tokens_(limits.burst),
      refilled_(scheduler.now()),
      next_token_(scheduler, [this] { ready_(); }),
      repeat_expiry_(scheduler, [this] { repeat_expired(); }),
      ready_later_(scheduler, [this] { ready_(); }) {
  RUBICON_ASSERT(limits.burst >= 1 && limits.rate >= 0);
}

void TelegramQueue::push(wire::Telegram telegram, SteadyTime expires, SendCallback done) {
  if (waiting_ >= limits_.queue) {
    ++counters_.refused;
    return report_later(std::move(done), SendOutcome::kRefused, "the send queue is full");
  }
  const auto queue = rank(telegram.priority) + (telegram.service == wire::Service::kRead ? kRanks : 0);
  queues_.push_back(queue, {std::move(telegram), expires, std::move(done)});
  ++waiting_;
  if (!in_flight() && !finishing_) ready_later_.request();
}

void TelegramQueue::refill() {
  const auto now = scheduler_.now();
  const std::chrono::duration<double> passed = now - std::exchange(refilled_, now);
  tokens_ = std::min<double>(limits_.burst, tokens_ + passed.count() * limits_.rate);
}

/// False if there are fewer tokens; `ready` is then called when there are enough.
bool TelegramQueue::has_tokens(double tokens) {
  if (limits_.rate <= 0 || tokens_ >= tokens) return true;
  const std::chrono::duration<double> wait((tokens - tokens_) / limits_.rate);
  next_token_.set(std::chrono::ceil<std::chrono::microseconds>(wait));
  return false;
}

/// A read leaves one token for telegrams that may follow.
std::optional<std::size_t> TelegramQueue::next_queue() {
  for (std::size_t queue = 0; queue < 2 * kRanks; ++queue) {
    if (queues_.empty(queue)) continue;
    const double tokens = queue < kRanks ? 1 : std::min(limits_.burst, 2U);
    return has_tokens(tokens) ? std::optional(queue) : std::nullopt;
  }
  return std::nullopt;
}

const wire::Telegram* TelegramQueue::take() {
  if (in_flight()) return nullptr;
  if (limits_.rate > 0) refill();
  if (repeats_ && in_flight_->expires <= scheduler_.now()) lose_in_flight();
  if (repeats_) {
    if (!has_tokens(1)) return nullptr;
    repeats_ = false;
    repeat_expiry_.clear();
  } else if (!take_next()) {
    return nullptr;
  }
  if (limits_.rate > 0) tokens_ -= 1;
  return &in_flight_->telegram;
}

bool TelegramQueue::take_next() {
  while (const auto queue = next_queue()) {
    auto item = queues_.pop_front(*queue);
    if (item.expires > scheduler_.now()) {
      --waiting_;
      in_flight_ = std::move(item);
      return true;
    }
    expired(std::move(item));
  }
  return false;
}

void TelegramQueue::finish(SendOutcome outcome, std::string_view why) {
  RUBICON_ASSERT(in_flight());
  Item item = std::move(*in_flight_);
  in_flight_.reset();
  if (!item.done) return;
  const auto watch = lifetime_.watch();
  finishing_ = true;
  item.done(outcome, why);
  if (!watch.ended()) finishing_ = false;
}

void TelegramQueue::line_lost() {
  if (!in_flight()) return;
  if (in_flight_->repeated || in_flight_->expires <= scheduler_.now()) return lose_in_flight();
  in_flight_->repeated = repeats_ = true;
  repeat_expiry_.set_at(in_flight_->expires);
}

void TelegramQueue::hand_over(TelegramQueue& to) {
  if (repeats_) {
    // The new line sends it first; it may be repeated no more.
    const auto queue = rank(in_flight_->telegram.priority);
    to.queues_.push_front(queue, std::move(*in_flight_));
    ++to.waiting_;
    in_flight_.reset();
    repeats_ = false;
    repeat_expiry_.clear();
  }
  for (std::size_t queue = 0; queue < 2 * kRanks; ++queue) {
    for (; !queues_.empty(queue); --waiting_, ++to.waiting_) to.queues_.push_back(queue, queues_.pop_front(queue));
  }
  to.ready_later_.request();
}

void TelegramQueue::repeat_expired() {
  if (repeats_) lose_in_flight();
}

void TelegramQueue::lose_in_flight() {
  ++counters_.lost;
  report_later(std::move(in_flight_->done), SendOutcome::kLost, kNoAnswer);
  in_flight_.reset();
  repeats_ = false;
  repeat_expiry_.clear();
}

void TelegramQueue::report_later(SendCallback done, SendOutcome outcome, std::string_view why) {
  if (!done) return;
  lifetime_.post(scheduler_, [done = std::move(done), outcome, why] { done(outcome, why); });
}

void TelegramQueue::expired(Item item) {
  ++counters_.expired;
  --waiting_;
  report_later(std::move(item.done), SendOutcome::kExpired, kExpiredBefore);
}

}  // namespace rubicon::networks::knx::line
