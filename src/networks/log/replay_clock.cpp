#include "networks/log/replay_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "model/type_catalogue.h"
#include "networks/log/file_time.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::log {

namespace {

/// Longest gap and position; so that sums of hostile gaps fit 64 bits of nanoseconds.
constexpr RecordTime kMaxTime = std::chrono::hours(24 * 365 * 100);

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
  gap = std::clamp(gap, RecordTime{0}, longest_gap_.value_or(kMaxTime));
  last_ = time;
  position_ = std::min(position_ + std::min(gap, kMaxTime), kMaxTime);
  return position_;
}

SteadyTime ReplayClock::due(RecordTime position) const {
  if (paused_) return SteadyTime::max();
  const RecordTime ahead = std::max(position - anchor_, RecordTime{0});
  if (speed_ == 0) return started_;
  const double wait = std::min(static_cast<double>(ahead.count()) / speed_, static_cast<double>(kMaxTime.count()));
  return started_ + RecordTime(static_cast<RecordTime::rep>(wait));
}

RecordTime ReplayClock::position(SteadyTime now) const {
  if (paused_) return std::min(anchor_, position_);
  if (speed_ == 0) return position_;
  const auto passed = static_cast<double>(std::chrono::floor<RecordTime>(now - started_).count()) * speed_;
  const auto played = RecordTime(static_cast<RecordTime::rep>(std::min(passed, static_cast<double>(kMaxTime.count()))));
  return std::min(anchor_ + played, position_);
}

namespace {

constexpr double kSlowest = 0.001;
constexpr double kFastest = 1e6;
/// Seconds since 1970 of the year 5000; beyond it no position lies.
constexpr double kMaxRecordTime = 95'617'584'000.0;

model::PointDescription property_of_replay(std::string_view type, model::DataType data) {
  model::PointDescription about;
  about.type = type;
  about.data_type = to_string(data);
  about.access = to_string(model::Access::kReadWrite);
  about.report = "state";
  return about;
}

RecordTime time_of_seconds(double seconds) {
  return RecordTime(static_cast<RecordTime::rep>(std::llround(seconds * 1e6)));
}

}  // namespace

std::vector<network::Control> replay_controls() {
  auto state = property_of_replay(kReplayState, model::DataType::kEnumeration);
  state.words = {{0, "playing"}, {1, "paused"}};
  auto speed = property_of_replay(kReplaySpeed, model::DataType::kReal);
  speed.minimum = kSlowest;
  speed.maximum = kFastest;
  auto position = property_of_replay(kReplayPosition, model::DataType::kReal);
  position.quantity = "time";
  position.unit = "s";
  return {
      {std::string(kReplayState), state}, {std::string(kReplaySpeed), speed}, {std::string(kReplayPosition), position}};
}

Result<bool> parse_replay_state(std::string_view text) {
  if (text == "playing" || text == "paused") return text == "playing";
  return fail(ErrorCode::kInvalid, fmt::format("{}, expected playing or paused", model::quoted(text)));
}

Result<double> parse_replay_speed(std::string_view text) {
  if (text == "max") return 0;
  const auto factor = base::parse_number<double>(text);
  if (factor && *factor >= kSlowest && *factor <= kFastest) return *factor;
  return fail(ErrorCode::kInvalid,
              fmt::format("{}, expected max or a factor from {} to {}", model::quoted(text), kSlowest, kFastest));
}

std::string replay_speed_text(double speed) {
  return speed == 0 ? "max" : fmt::format("{}", speed);
}

Result<ReplayTarget> parse_replay_target(std::string_view text) {
  using From = ReplayTarget::From;
  const bool relative = text.starts_with('+') || text.starts_with('-');
  const bool back = text.starts_with('-');
  if (const auto span = base::parse_duration(relative ? text.substr(1) : text)) {
    const auto time = std::chrono::floor<RecordTime>(*span);
    return ReplayTarget{relative ? From::kHere : From::kBeginning, back ? -time : time};
  }
  if (const auto seconds = base::parse_number<double>(text); seconds && *seconds >= 0 && *seconds <= kMaxRecordTime)
    return ReplayTarget{From::kScale, time_of_seconds(*seconds)};
  if (const auto date = parse_iso_time(text)) return ReplayTarget{From::kScale, date->time.time_since_epoch(), true};
  return fail(ErrorCode::kInvalid,
              fmt::format("{}, expected seconds, a date such as 2026-01-31T12:00:00Z, a span from the beginning (90s), "
                          "or from here (+30s, -30s)",
                          model::quoted(text)));
}

std::string replay_time_text(RecordTime time) {
  return fmt::format("{:.3f}", std::chrono::duration<double>(time).count());
}

}  // namespace rubicon::networks::log
