#include "networks/log/replay_clock.h"

#include <algorithm>
#include <utility>

namespace rubicon::networks::log {

namespace {

/// Longest gap and position; so that sums of hostile gaps fit 64 bits of nanoseconds.
constexpr RecordTime kLongest = std::chrono::hours(24 * 365 * 100);

}  // namespace

ReplayClock::ReplayClock(double speed, std::optional<Duration> longest_gap, Duration start)
    : speed_(speed), start_(std::chrono::floor<RecordTime>(start)) {
  if (longest_gap) longest_gap_ = std::chrono::floor<RecordTime>(*longest_gap);
}

void ReplayClock::restart(SteadyTime now) {
  started_ = now;
  position_ = pending_ = RecordTime{0};
  last_.reset();
  went_back_ = false;
}

void ReplayClock::break_off(RecordTime gap) {
  if (last_) pending_ = gap;
  last_.reset();
}

RecordTime ReplayClock::advance(RecordTime time) {
  RecordTime gap = last_ ? time - *last_ : std::exchange(pending_, RecordTime{0});
  went_back_ = gap < RecordTime{0};
  gap = std::clamp(gap, RecordTime{0}, longest_gap_.value_or(kLongest));
  last_ = time;
  position_ = std::min(position_ + std::min(gap, kLongest), kLongest);
  return position_;
}

SteadyTime ReplayClock::due(RecordTime position) const {
  const RecordTime ahead = std::max(position - start_, RecordTime{0});
  if (speed_ == 0) return started_;
  const double wait = std::min(static_cast<double>(ahead.count()) / speed_, static_cast<double>(kLongest.count()));
  return started_ + RecordTime(static_cast<RecordTime::rep>(wait));
}

}  // namespace rubicon::networks::log
