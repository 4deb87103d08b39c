#include "networks/knx/secure/routing_clock.h"

#include <algorithm>
#include <utility>

namespace rubicon::networks::knx::secure {

namespace {

using namespace std::chrono_literals;

std::uint64_t ticks_of(Duration span) {
  return static_cast<std::uint64_t>(std::chrono::floor<std::chrono::milliseconds>(span).count());
}

}  // namespace

RoutingClock::RoutingClock(Scheduler& scheduler, Settings settings, Callbacks callbacks)
    : scheduler_(scheduler),
      settings_(settings),
      callbacks_(std::move(callbacks)),
      base_(std::min(settings.start, kMaxTimer)),
      base_time_(scheduler.now()),
      random_(settings.seed),
      deadline_(scheduler, [this] { due(); }) {}

std::uint64_t RoutingClock::now() const {
  return std::min(base_ + ticks_of(scheduler_.now() - base_time_), kMaxTimer);
}

void RoutingClock::start() {
  phase_ = Phase::kAsking;
  update_.reset();
  asked_ = random_tag();
  deadline_.set(100ms + 12 * settings_.latency / 10 + 2 * settings_.latency);
  callbacks_.notify(settings_.own, asked_);
}

void RoutingClock::stop() {
  phase_ = Phase::kStopped;
  update_.reset();
  deadline_.clear();
}

void RoutingClock::take_over(std::uint64_t timer) {
  base_ = std::min(timer, kMaxTimer);
  base_time_ = scheduler_.now();
}

RoutingClock::Age RoutingClock::age_of(std::uint64_t timer) const {
  const auto own = now();
  if (timer > own) return Age::kAhead;
  const auto late = own - timer, latency = ticks_of(settings_.latency);
  if (10 * late < latency) return Age::kFresh;
  return late < latency ? Age::kLate : Age::kOld;
}

RoutingClock::Verdict RoutingClock::received_wrapper(std::uint64_t timer, const Serial& serial, std::uint16_t tag) {
  if (!synchronised()) return Verdict::kEarly;
  const auto age = age_of(timer);
  if (age == Age::kOld) {
    schedule_update(serial, tag);
    return Verdict::kOld;
  }
  if (age == Age::kAhead) take_over(timer);
  if (age != Age::kLate && !update_) schedule_periodic();
  return Verdict::kAccepted;
}

void RoutingClock::received_notify(std::uint64_t timer, const Serial& serial, std::uint16_t tag) {
  if (phase_ == Phase::kStopped) return;
  const auto age = age_of(timer);
  if (phase_ == Phase::kAsking) {
    if (age == Age::kAhead) take_over(timer);
    if (serial != settings_.own || tag != asked_) return;
    phase_ = Phase::kFollower;
    schedule_periodic();
    return callbacks_.synchronised();
  }
  if (age == Age::kOld) return schedule_update(serial, tag);
  if (age == Age::kLate) return;
  if (age == Age::kAhead) take_over(timer);
  phase_ = Phase::kFollower;
  schedule_periodic();
}

void RoutingClock::sent_wrapper() {
  if (synchronised() && !update_) schedule_periodic();
}

void RoutingClock::schedule_update(const Serial& serial, std::uint16_t tag) {
  if (!synchronised() || update_) return;
  update_ = Update{serial, tag};
  const auto q = settings_.latency / 10;
  deadline_.set(keeper() ? between(100ms, 100ms + q) : between(100ms + 2 * q, 100ms + 12 * q));
}

void RoutingClock::schedule_periodic() {
  update_.reset();
  const auto q = settings_.latency / 10;
  deadline_.set(keeper() ? between(10s, 10s + 3 * q) : between(10s + 4 * q, 10s + 14 * q));
}

void RoutingClock::due() {
  if (phase_ == Phase::kAsking) {
    phase_ = Phase::kKeeper;
    schedule_periodic();
    return callbacks_.synchronised();
  }
  const auto update = std::exchange(update_, std::nullopt);
  phase_ = Phase::kKeeper;
  schedule_periodic();
  if (update) return callbacks_.notify(update->serial, update->tag);
  callbacks_.notify(settings_.own, random_tag());
}

Duration RoutingClock::between(Duration least, Duration most) {
  return Duration(std::uniform_int_distribution<Duration::rep>(least.count(), most.count())(random_));
}

}  // namespace rubicon::networks::knx::secure
