#include "networks/knx/line/hold_off.h"

#include <algorithm>
#include <utility>

namespace rubicon::networks::knx::line {

namespace {

using namespace std::chrono_literals;

constexpr Duration kShortest = 1s, kLongest = 60s;
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
  next_ = std::min(next_ * 2, kLongest);
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
  return std::chrono::duration_cast<Duration>(kLongest * jitter());
}

void HoldOff::ended(Duration lived) {
  if (lived >= kGoodLife) next_ = kShortest;
}

}  // namespace rubicon::networks::knx::line
