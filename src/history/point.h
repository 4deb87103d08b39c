#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "rubicon/time.hpp"

namespace rubicon::history {

/// One value of a series, or the mark that a gap begins.
struct Point {
  std::int64_t time = 0;  ///< milliseconds since 1970 UTC
  double value = 0;       ///< not a number = from here on there is no good value

  bool gap() const { return std::isnan(value); }
  friend bool operator==(const Point& a, const Point& b) {
    return a.time == b.time && (a.value == b.value || (a.gap() && b.gap()));
  }
};
using Points = std::vector<Point>;

inline constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

/// Times are within this of 1970 (about 290,000 years), so that no difference of two overflows.
inline constexpr std::int64_t kFurthest = 9'000'000'000'000'000;

// Spans of time in milliseconds.
inline constexpr std::int64_t kSecond = 1000, kMinute = 60 * kSecond, kHour = 60 * kMinute, kDay = 24 * kHour;

/// The last multiple of `width` since 1970 that is not after `time`.
inline std::int64_t floor_to(std::int64_t time, std::int64_t width) {
  const auto rest = time % width;
  return time - (rest < 0 ? rest + width : rest);
}

/// Rounded down; times further away are moved to kFurthest.
inline std::int64_t to_milliseconds(WallTime time) {
  const auto whole = std::chrono::floor<std::chrono::milliseconds>(time).time_since_epoch().count();
  return std::clamp<std::int64_t>(whole, -kFurthest, kFurthest);
}
/// Times further away, of a damaged file, are moved to kFurthest: a WallTime has no room for them.
inline WallTime from_milliseconds(std::int64_t time) {
  return WallTime(std::chrono::milliseconds(std::clamp(time, -kFurthest, kFurthest)));
}
inline std::int64_t milliseconds(Duration span) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(span).count();
}

}  // namespace rubicon::history
