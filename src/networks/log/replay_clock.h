#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "network/network.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::log {

/// A time in a recording. Microseconds, so that it covers every calendar.
using RecordTime = std::chrono::microseconds;

/// Converts times of a recording to times of its replay. The pause between two records is divided by the speed and may
/// have an upper limit; after a step back there is none. Free of drift: due times count from the start.
class ReplayClock {
 public:
  /// Speed 0 = as fast as possible. `start` = how much of the recording is skipped at the beginning.
  ReplayClock(double speed, std::optional<Duration> longest_gap, Duration start);

  /// The recording starts now; paused, it starts when resume() is called.
  void restart(SteadyTime now);
  void set_speed(SteadyTime now, double speed);
  void pause(SteadyTime now);
  void resume(SteadyTime now);
  /// The recording goes on now at this position; nothing behind it is skipped.
  void jump(SteadyTime now, RecordTime position);
  /// The time of the next record is unrelated to the last one: it is played `gap` after it.
  void break_off(RecordTime gap);
  /// Takes the time of the next record; returns its position in the recording.
  RecordTime advance(RecordTime time);

  bool is_skipped(RecordTime position) const { return position < skip_; }
  /// SteadyTime::max() while paused.
  SteadyTime due(RecordTime position) const;
  /// What plays now: between the last record and the one before.
  RecordTime position(SteadyTime now) const;
  bool went_back() const { return went_back_; }
  bool paused() const { return paused_; }
  double speed() const { return speed_; }
  std::optional<RecordTime> longest_gap() const { return longest_gap_; }

 private:
  double speed_;
  std::optional<RecordTime> longest_gap_;
  RecordTime start_;
  RecordTime skip_{0};    ///< positions before it are skipped
  RecordTime anchor_{0};  ///< the position that played at started_
  SteadyTime started_{};
  bool paused_ = false;
  RecordTime position_{0};
  RecordTime pending_{0};
  std::optional<RecordTime> last_;
  bool went_back_ = false;
};

// What users set of a replay, as texts (README.md, "Control a replay").

inline constexpr std::string_view kReplayState = "replay-state", kReplaySpeed = "replay-speed",
                                  kReplayPosition = "replay-position";

/// The three of them with their descriptions.
std::vector<network::Control> replay_controls();

/// True: playing, false: paused.
Result<bool> parse_replay_state(std::string_view text);
/// `max` = 0, or a factor from 0.001 to 1000000.
Result<double> parse_replay_speed(std::string_view text);
std::string replay_speed_text(double speed);

/// Where to go on: a time of the recording as its position shows it, or a span from its beginning or from here.
struct ReplayTarget {
  enum class From { kScale, kBeginning, kHere };
  From from = From::kScale;
  RecordTime time{};
  bool is_date = false;  ///< only recordings with absolute times have it
};
/// `1795234047.5`, `2026-11-22T10:00:00Z`, `90s`, `+30s`, `-1.5min`.
Result<ReplayTarget> parse_replay_target(std::string_view text);
/// Seconds with milliseconds.
std::string replay_time_text(RecordTime time);

}  // namespace rubicon::networks::log
