#include "networks/zigbee/device/silence.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::zigbee::device {

namespace {

constexpr Duration kAskAgain = std::chrono::minutes(10);
/// No place for the question in this moment.
constexpr Duration kNoPlaceTime = std::chrono::seconds(1);

std::string hours_text(Duration span) {
  const auto minutes = std::chrono::duration_cast<std::chrono::minutes>(span).count();
  return minutes % 60 == 0 ? fmt::format("{} h", minutes / 60) : fmt::format("{} min", minutes);
}

}  // namespace

Silence::Silence(Scheduler& scheduler, Calls calls)
    : scheduler_(scheduler), calls_(std::move(calls)), deadline_(scheduler, [this] { due(); }) {}

void Silence::limit(std::optional<Duration> limit, bool can_ask) {
  limit_ = limit;
  can_ask_ = can_ask;
  schedule();
}

void Silence::heard(Duration ago) {
  const auto when = scheduler_.now() - ago;
  if (phase_ == Phase::kHeard && when <= heard_at_) return;
  heard_at_ = std::max(heard_at_, when);
  if (!limit_ || ago < *limit_) phase_ = Phase::kHeard;
  schedule();
}

void Silence::line(bool up) {
  up_ = up;
  phase_ = Phase::kHeard;
  heard_at_ = scheduler_.now();
  schedule();
}

void Silence::schedule() {
  if (!limit_ || !up_) return deadline_.clear();
  if (phase_ == Phase::kHeard) deadline_.set_at(heard_at_ + *limit_);
}

void Silence::due() {
  if (phase_ == Phase::kAsked) {
    phase_ = Phase::kUnreachable;
    calls_.unreachable(fmt::format("not heard for {}", hours_text(*limit_)));
    return deadline_.set(kAskAgain);
  }
  if (can_ask_ && calls_.ask()) {
    if (phase_ == Phase::kHeard) phase_ = Phase::kAsked;
    return deadline_.set(phase_ == Phase::kAsked ? kProbeTime : kAskAgain);
  }
  if (can_ask_) return deadline_.set(kNoPlaceTime);
  if (phase_ == Phase::kUnreachable) return deadline_.set(kAskAgain);
  phase_ = Phase::kUnreachable;
  calls_.unreachable(fmt::format("not heard for {}", hours_text(*limit_)));
}

}  // namespace rubicon::networks::zigbee::device
