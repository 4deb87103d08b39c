#pragma once

#include <chrono>
#include <cstdint>

namespace rubicon::base {

using Duration = std::chrono::nanoseconds;

/// Monotonic time, for deadlines, intervals and ages. Its epoch has no meaning.
using SteadyTime = std::chrono::time_point<std::chrono::steady_clock, Duration>;

/// UTC in microseconds since 1970-01-01, as in tuples. Zero = not known.
using WallTime = std::chrono::sys_time<std::chrono::microseconds>;

/// Seconds since 1970-01-01 UTC with microseconds as fraction: the form of every time in JSON.
inline double to_seconds(WallTime time) {
  return static_cast<double>(time.time_since_epoch().count()) / 1e6;
}

}  // namespace rubicon::base

namespace rubicon {
using base::Duration;
using base::SteadyTime;
using base::WallTime;
}  // namespace rubicon
