#include "networks/log/replay_controls.h"

#include <fmt/format.h>

#include <cmath>

#include "base/text.h"
#include "model/type_catalogue.h"
#include "networks/log/iso_time.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::log {

namespace {

constexpr double kSlowest = 0.001;
constexpr double kFastest = 1e6;
/// Seconds since 1970 of the year 5000; beyond it no position lies.
constexpr double kLatest = 95'617'584'000.0;

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
  if (const auto seconds = base::parse_number<double>(text); seconds && *seconds >= 0 && *seconds <= kLatest)
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
