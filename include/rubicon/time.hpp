#pragma once

#include <chrono>
#include <cstdint>

namespace rubicon::base {

using Duration = std::chrono::nanoseconds;

/// Monotonic time: deadlines, intervals, ages. Its zero means nothing.
using SteadyTime = std::chrono::time_point<std::chrono::steady_clock, Duration>;

/// UTC, microseconds since 1970: what stands in tuples. Zero = not known.
using WallTime = std::chrono::sys_time<std::chrono::microseconds>;

/// Seconds since 1970 with microseconds as fraction: the spelling of every time in tuples and JSON lines.
inline double to_seconds(WallTime time) {
  return static_cast<double>(time.time_since_epoch().count()) / 1e6;
}

}  // namespace rubicon::base

namespace rubicon {
using base::Duration;
using base::SteadyTime;
using base::WallTime;
}  // namespace rubicon
