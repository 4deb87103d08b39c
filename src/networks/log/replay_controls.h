#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "network/network.h"
#include "networks/log/replay_clock.h"

namespace rubicon::networks::log {

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
