#include "networks/zigbee/device/polling.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::zigbee::device {

Polling::Polling(Scheduler& scheduler, Duration retry, Ask ask)
    : scheduler_(scheduler), retry_(retry), ask_(std::move(ask)), deadline_(scheduler, [this] { step(); }) {}

void Polling::once(const std::vector<std::size_t>& properties) {
  once_.insert(properties.begin(), properties.end());
  schedule();
}

void Polling::demand(std::vector<std::size_t> properties, Duration period) {
  demanded_ = std::move(properties);
  period_ = std::max(period, kMinTime);
  const bool polls = period > Duration(0) && !demanded_.empty();
  next_poll_ = polls ? scheduler_.now() + period_ : SteadyTime::max();
  schedule();
}

void Polling::clear() {
  once_.clear();
  demand({}, Duration(0));
}

void Polling::line(bool up) {
  up_ = up;
  if (!up) once_.clear();
  schedule();
}

void Polling::step() {
  const auto now = scheduler_.now();
  auto wanted = once_;
  if (next_poll_ <= now) wanted.insert(demanded_.begin(), demanded_.end());
  if (!up_ || wanted.empty()) return schedule();
  if (!ask_({wanted.begin(), wanted.end()})) {
    not_before_ = now + retry_;
    return schedule();
  }
  once_.clear();
  not_before_ = now + kMinTime;
  if (next_poll_ <= now) next_poll_ = now + period_;
  schedule();
}

void Polling::schedule() {
  auto next = once_.empty() ? next_poll_ : scheduler_.now();
  if (!up_) next = SteadyTime::max();
  if (next != SteadyTime::max()) next = std::max(next, not_before_);
  deadline_.set_at(next);
}

namespace {

constexpr Duration kAskAgain = std::chrono::minutes(10);
/// No place for the question in this moment.
constexpr Duration kNoPlaceTime = std::chrono::seconds(1);

std::string hours_text(Duration span) {
  const auto minutes = std::chrono::duration_cast<std::chrono::minutes>(span).count();
  return minutes % 60 == 0 ? fmt::format("{} h", minutes / 60) : fmt::format("{} min", minutes);
}

}  // namespace

Silence::Silence(Scheduler& scheduler, Callbacks calls)
    : scheduler_(scheduler), callbacks_(std::move(calls)), deadline_(scheduler, [this] { due(); }) {}

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
    callbacks_.unreachable(fmt::format("not heard for {}", hours_text(*limit_)));
    return deadline_.set(kAskAgain);
  }
  if (can_ask_ && callbacks_.ask()) {
    if (phase_ == Phase::kHeard) phase_ = Phase::kAsked;
    return deadline_.set(phase_ == Phase::kAsked ? kProbeTime : kAskAgain);
  }
  if (can_ask_) return deadline_.set(kNoPlaceTime);
  if (phase_ == Phase::kUnreachable) return deadline_.set(kAskAgain);
  phase_ = Phase::kUnreachable;
  callbacks_.unreachable(fmt::format("not heard for {}", hours_text(*limit_)));
}

}  // namespace rubicon::networks::zigbee::device
