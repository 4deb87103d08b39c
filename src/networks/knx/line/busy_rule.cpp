#include "networks/knx/line/busy_rule.h"

#include <algorithm>

namespace rubicon::networks::knx::line {

namespace {

using namespace std::chrono_literals;

constexpr auto kApart = 10ms, kRandomStep = 50ms, kSlowStep = 100ms, kFallStep = 5ms;

}  // namespace

SteadyTime BusyRule::slow_until() const {
  return resume_at_ + n_ * kSlowStep;
}

unsigned BusyRule::level(SteadyTime now) const {
  if (n_ == 0 || now < slow_until()) return n_;
  const auto fallen = (now - slow_until()) / kFallStep;
  return fallen >= n_ ? 0 : n_ - static_cast<unsigned>(fallen);
}

void BusyRule::receive(SteadyTime now, Duration wait) {
  const bool waiting = now < resume_at_;
  const auto level_now = level(now);
  const bool counts = level_now == 0 || now - counted_ > kApart;
  n_ = counts ? std::min(level_now + 1, kMaxLevel) : level_now;
  if (counts) counted_ = now;
  if (waiting && now + wait <= resume_at_) return;
  const double part = std::generate_canonical<double, 53>(random_);
  resume_at_ = now + wait + std::chrono::duration_cast<Duration>(part * n_ * kRandomStep);
}

}  // namespace rubicon::networks::knx::line
