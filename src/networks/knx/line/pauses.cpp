#include "networks/knx/line/pauses.h"

#include <algorithm>
#include <utility>

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

namespace {

constexpr Duration kMinTime = 1s, kMaxTime = 60s;
constexpr Duration kGoodLife = 60s;
constexpr Duration kShortLife = 10s, kFightWindow = 300s;
constexpr std::size_t kFightEnds = 3;

}  // namespace

/// 0.8 to 1.2 (xorshift: any distribution will do).
double HoldOff::jitter() {
  random_ ^= random_ << 13;
  random_ ^= random_ >> 7;
  random_ ^= random_ << 17;
  return 0.8 + 0.4 * static_cast<double>(random_ % 1000) / 1000;
}

Duration HoldOff::slot_taken() {
  const auto pause = next_;
  next_ = std::min(next_ * 2, kMaxTime);
  return std::chrono::duration_cast<Duration>(pause * jitter());
}

Duration HoldOff::misconfigured() {
  return std::exchange(misconfigured_before_, true) ? Duration(300s) : Duration(60s);
}

Duration HoldOff::closed_by_server(SteadyTime now, Duration lived) {
  while (!short_lives_.empty() && now - short_lives_.front() > kFightWindow) short_lives_.pop_front();
  if (lived >= kShortLife) return {};
  short_lives_.push_back(now);
  if (short_lives_.size() <= kFightEnds) return {};
  short_lives_.pop_front();
  return std::chrono::duration_cast<Duration>(kMaxTime * jitter());
}

void HoldOff::ended(Duration lived) {
  if (lived >= kGoodLife) next_ = kMinTime;
}

}  // namespace rubicon::networks::knx::line
