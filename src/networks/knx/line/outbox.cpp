#include "networks/knx/line/outbox.h"

#include <algorithm>
#include <utility>

#include "base/assert.h"

namespace rubicon::networks::knx::line {

namespace {

/// Expired telegrams are looked for at most this often.
constexpr Duration kExpiryStep = std::chrono::milliseconds(10);
constexpr std::string_view kNoTime = "its time was over before it could be sent";
constexpr std::string_view kNoAnswer = "the line was lost before the interface acknowledged it";

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

Outbox::Outbox(Scheduler& scheduler, Limits limits, std::function<void()> ready)
    : scheduler_(scheduler),
      limits_(limits),
      ready_(std::move(ready)),
      tokens_(limits.burst),
      refilled_(scheduler.now()),
      token_(scheduler, [this] { ready_(); }),
      expiry_(scheduler, [this] { expire(); }) {
  RUBICON_ASSERT(limits.burst >= 1 && limits.rate >= 0);
}

Outbox::~Outbox() {
  *alive_ = false;
}

void Outbox::push(wire::Telegram telegram, SteadyTime expires, SentCall done) {
  if (waiting_ >= limits_.queue) {
    ++counters_.refused;
    return report_later(std::move(done), Sent::kRefused, "too many telegrams wait already");
  }
  auto& queues = telegram.service == wire::Service::kRead ? reads_ : queues_;
  queues[rank(telegram.priority)].push_back({std::move(telegram), expires, std::move(done), false});
  ++waiting_;
  if (expires < expiry_.due()) expiry_.set_at(expires);
  if (!under_way() && !finishing_) call_ready_later();
}

void Outbox::call_ready_later() {
  if (std::exchange(ready_asked_, true)) return;
  scheduler_.post([this, alive = alive_] {
    if (!*alive) return;
    ready_asked_ = false;
    ready_();
  });
}

void Outbox::refill() {
  const auto now = scheduler_.now();
  const std::chrono::duration<double> passed = now - std::exchange(refilled_, now);
  tokens_ = std::min<double>(limits_.burst, tokens_ + passed.count() * limits_.rate);
}

/// True if there are so many tokens; else ready() is called when there are.
bool Outbox::may_go(double tokens) {
  if (limits_.rate <= 0 || tokens_ >= tokens) return true;
  const std::chrono::duration<double> wait((tokens - tokens_) / limits_.rate);
  const auto pause = std::chrono::ceil<std::chrono::microseconds>(wait);
  token_.set(pause);
  return false;
}

/// Reads leave a token for whatever else may come.
Outbox::Queue* Outbox::next_queue() {
  const auto waits = [](const Queue& queue) { return !queue.empty(); };
  const auto queue = std::find_if(queues_.begin(), queues_.end(), waits);
  if (queue != queues_.end()) return may_go(1) ? &*queue : nullptr;
  const auto read = std::find_if(reads_.begin(), reads_.end(), waits);
  if (read == reads_.end()) return nullptr;
  return may_go(std::min(limits_.burst, 2U)) ? &*read : nullptr;
}

const wire::Telegram* Outbox::take() {
  if (under_way()) return nullptr;
  if (limits_.rate > 0) refill();
  if (waits_again_ && under_way_->expires <= scheduler_.now()) lose_under_way();
  if (waits_again_) {
    if (!may_go(1)) return nullptr;
    waits_again_ = false;
  } else if (!take_next()) {
    return nullptr;
  }
  if (limits_.rate > 0) tokens_ -= 1;
  return &under_way_->telegram;
}

bool Outbox::take_next() {
  while (auto* const queue = next_queue()) {
    under_way_ = std::move(queue->front());
    queue->pop_front();
    --waiting_;
    if (under_way_->expires > scheduler_.now()) return true;
    ++counters_.expired;
    report_later(std::move(under_way_->done), Sent::kExpired, kNoTime);
    under_way_.reset();
  }
  return false;
}

void Outbox::finish(Sent outcome, std::string_view why) {
  RUBICON_ASSERT(under_way());
  Item item = std::move(*under_way_);
  under_way_.reset();
  if (!item.done) return;
  const auto alive = alive_;
  finishing_ = true;
  item.done(outcome, why);
  if (*alive) finishing_ = false;
}

void Outbox::line_lost() {
  if (!under_way()) return;
  if (!under_way_->again && under_way_->expires > scheduler_.now()) {
    under_way_->again = waits_again_ = true;
    if (under_way_->expires < expiry_.due()) expiry_.set_at(under_way_->expires);
    return;
  }
  lose_under_way();
}

void Outbox::lose_under_way() {
  ++counters_.lost;
  report_later(std::move(under_way_->done), Sent::kLost, kNoAnswer);
  under_way_.reset();
  waits_again_ = false;
}

void Outbox::report_later(SentCall done, Sent outcome, std::string_view why) {
  if (!done) return;
  scheduler_.post([done = std::move(done), outcome, why, alive = alive_] {
    if (*alive) done(outcome, why);
  });
}

void Outbox::expire_in(Queue& queue, SteadyTime now, SteadyTime& next) {
  std::erase_if(queue, [&](Item& item) {
    if (item.expires > now) {
      next = std::min(next, item.expires);
      return false;
    }
    ++counters_.expired;
    --waiting_;
    report_later(std::move(item.done), Sent::kExpired, kNoTime);
    return true;
  });
}

void Outbox::expire() {
  const auto now = scheduler_.now();
  auto next = SteadyTime::max();
  for (auto& queue : queues_) expire_in(queue, now, next);
  for (auto& queue : reads_) expire_in(queue, now, next);
  if (waits_again_ && under_way_->expires <= now) {
    lose_under_way();
  } else if (waits_again_) {
    next = std::min(next, under_way_->expires);
  }
  if (next != SteadyTime::max()) expiry_.set_at(std::max(next, now + kExpiryStep));
}

}  // namespace rubicon::networks::knx::line
