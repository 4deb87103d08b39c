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
  anchor_ = skip_ = start_;
  position_ = pending_ = RecordTime{0};
  last_.reset();
  went_back_ = false;
}

void ReplayClock::set_speed(SteadyTime now, double speed) {
  anchor_ = position(now);
  started_ = now;
  speed_ = speed;
}

void ReplayClock::pause(SteadyTime now) {
  anchor_ = position(now);
  paused_ = true;
}

void ReplayClock::resume(SteadyTime now) {
  if (!std::exchange(paused_, false)) return;
  started_ = now;
}

void ReplayClock::jump(SteadyTime now, RecordTime position) {
  anchor_ = skip_ = position;
  started_ = now;
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
  if (paused_) return SteadyTime::max();
  const RecordTime ahead = std::max(position - anchor_, RecordTime{0});
  if (speed_ == 0) return started_;
  const double wait = std::min(static_cast<double>(ahead.count()) / speed_, static_cast<double>(kLongest.count()));
  return started_ + RecordTime(static_cast<RecordTime::rep>(wait));
}

RecordTime ReplayClock::position(SteadyTime now) const {
  if (paused_) return std::min(anchor_, position_);
  if (speed_ == 0) return position_;
  const auto passed = static_cast<double>(std::chrono::floor<RecordTime>(now - started_).count()) * speed_;
  const auto played = RecordTime(static_cast<RecordTime::rep>(std::min(passed, static_cast<double>(kLongest.count()))));
  return std::min(anchor_ + played, position_);
}

}  // namespace rubicon::networks::log
