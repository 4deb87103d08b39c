#include "networks/log/log_network_impl.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::log {

void LastReadings::joined(const std::string& device, const model::Join& join) {
  auto& known = devices_[device];
  for (const auto& capability : join.capabilities) {
    if (capability.report == model::Report::kEvent) known.events.insert(capability.point);
  }
}

bool LastReadings::is_event(const Device& device, const model::PointId& point) const {
  const auto* type = types_.find(point.type);
  return type ? type->report == model::Report::kEvent : device.events.contains(point);
}

void LastReadings::keep(const std::string& device, const model::Updates& updates, WallTime when) {
  auto& known = devices_[device];
  for (const auto& reading : updates.readings) {
    if (is_event(known, reading.point)) continue;
    auto& last = known.last[reading.point] = reading;
    if (last.user_time == WallTime{}) last.user_time = when;
  }
}

void LastReadings::clear() {
  for (auto& [device, known] : devices_) known.last.clear();
}

std::vector<std::pair<std::string, model::Body>> LastReadings::take() {
  std::vector<std::pair<std::string, model::Body>> messages;
  for (auto& [device, known] : devices_) {
    if (known.last.empty()) continue;
    model::Updates updates;
    for (auto& [point, reading] : known.last) updates.readings.push_back(std::move(reading));
    messages.emplace_back(device, std::move(updates));
  }
  clear();
  return messages;
}

namespace {

/// Between two reports of the position.
constexpr Duration kPositionEvery = std::chrono::seconds(1);

}  // namespace

void LogNetwork::add_replay_texts(std::map<std::string, std::string>& texts) const {
  texts[std::string(kReplayState)] = ended_ ? "ended" : clock_.paused() ? "paused" : "playing";
  texts[std::string(kReplaySpeed)] = replay_speed_text(clock_.speed());
  if (begin_) texts[std::string(kReplayPosition)] = replay_time_text(here());
  if (begin_) texts["replay-begin"] = replay_time_text(*begin_);
  if (end_) texts["replay-end"] = replay_time_text(*end_);
}

/// Between steps the position moves too.
void LogNetwork::tick() {
  tick_ = host_.scheduler().after(kPositionEvery, [this] {
    if (!line_ || ended_ || clock_.paused()) return;
    reporter_.line_changed();
    tick();
  });
}

Result<void> LogNetwork::control(std::string_view name, std::string_view text) {
  const bool broken = recording_ && recording_->failure();
  if (!line_ || !up_ || broken)
    return fail(ErrorCode::kRefused,
                fmt::format("the recording cannot be played now{}{}", reason_.empty() ? "" : ": ", reason_));
  Result<void> done = fail(ErrorCode::kNotFound, fmt::format("a recording has no {}", name));
  if (name == kReplayState) {
    const auto playing = parse_replay_state(text);
    done = playing ? set_playing(*playing) : fail(playing.error());
  } else if (name == kReplaySpeed) {
    const auto speed = parse_replay_speed(text);
    done = speed ? Result<void>() : fail(speed.error());
    if (speed) clock_.set_speed(host_.scheduler().now(), *speed);
  } else if (name == kReplayPosition) {
    done = go_to(text);
  }
  if (!done || !line_) return done;
  reporter_.line_changed();
  next_turn_.request();
  return done;
}

Result<void> LogNetwork::set_playing(bool playing) {
  if (ended_ && !playing) return fail(ErrorCode::kRefused, "the recording ended");
  if (ended_) {
    if (auto begun = rewind(); !begun) return begun;
  }
  if (playing) {
    clock_.resume(host_.scheduler().now());
    tick();
  } else {
    timer_.cancel();
    clock_.pause(host_.scheduler().now());
  }
  return {};
}

Result<RecordTime> LogNetwork::time_of(const ReplayTarget& target) const {
  if (!begin_) return fail(ErrorCode::kRefused, "the recording has no position yet");
  if (target.is_date && !recording_->absolute_times())
    return fail(ErrorCode::kInvalid, "this recording has no dates, expected seconds from its beginning");
  using From = ReplayTarget::From;
  const auto from = target.from == From::kBeginning ? *begin_ : target.from == From::kHere ? here() : RecordTime{0};
  const auto time = std::max(from + target.time, *begin_);
  if (!end_ || time <= *end_) return time;
  return fail(ErrorCode::kOutOfRange,
              fmt::format("{} is after the end of the recording, {}", replay_time_text(time), replay_time_text(*end_)));
}

Result<void> LogNetwork::go_to(std::string_view text) {
  const auto parsed = parse_replay_target(text);
  if (!parsed) return fail(parsed.error());
  const auto time = time_of(*parsed);
  if (!time) return fail(time.error());
  if (ended_ || kept_ || *time < here()) {
    if (auto begun = rewind(); !begun) return begun;
  }
  timer_.cancel();
  target_ = *time;
  end_search();
  return {};
}

/// Where the recording is: between the last step and the one before, or where a search leads.
RecordTime LogNetwork::here() const {
  if (target_) return *target_;
  const auto ahead = ended_ || !step_ ? RecordTime{0} : position_ - clock_.position(host_.scheduler().now());
  return std::max(time_ - ahead, begin_.value_or(RecordTime{0}));
}

/// Ends the search if the step that was read lies at or behind the target: the recording goes on at the target.
void LogNetwork::end_search() {
  if (!target_ || !step_ || time_ < *target_) return;
  const auto lead = std::min(time_ - *target_, clock_.longest_gap().value_or(RecordTime::max()));
  clock_.jump(host_.scheduler().now(), position_ - lead);
  target_.reset();
  auto step = std::move(step_);
  if (deliver_kept())
    behind_kept_ = std::move(step);
  else
    step_ = std::move(step);
}

/// Makes the readings before the target the next step; false: there are none.
bool LogNetwork::deliver_kept() {
  auto messages = last_readings_.take();
  if (messages.empty()) return false;
  step_ = Step{time_, std::nullopt, std::move(messages)};
  next_message_ = 0;
  kept_ = true;
  return true;
}

}  // namespace rubicon::networks::log
