#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "history/series.h"

namespace rubicon::history {

/// A steady value is stored again after this time at the latest, so that silence and steadiness differ.
inline constexpr std::int64_t kRepeat = 10 * kMinute;
/// Without a point for this long a series was not observed.
inline constexpr std::int64_t kSilence = 25 * kMinute;

/// Time cut into buckets of one width, from a multiple of it since 1970 to another. Milliseconds.
struct Grid {
  std::int64_t from = 0, to = 0;  ///< [from, to)
  std::int64_t width = 1;

  std::size_t size() const { return static_cast<std::size_t>((to - from) / width); }
  bool contains(std::int64_t time) const { return time >= from && time < to; }
  std::size_t place(std::int64_t time) const { return static_cast<std::size_t>((time - from) / width); }
};

/// The finest grid that covers [from, to) with at most `buckets` (1 or more) buckets of a width that people know: 1, 2
/// or 5 of a power of ten of milliseconds, then seconds, minutes, hours and days. The same span of time always has the
/// same width, so that what was fetched can be used again.
Grid grid_of(std::int64_t from, std::int64_t to, std::size_t buckets);

/// The points of a span of time, added up.
struct Summed {
  std::int64_t start = 0, end = 0;  ///< of the first and the last point
  std::uint32_t count = 0;          ///< without gaps
  double first = 0, minimum = 0, maximum = 0, sum = 0, last = 0;
  double area = 0;        ///< values times the milliseconds in which each was in force
  std::int64_t held = 0;  ///< these milliseconds together

  /// Adds a value; `time` not before the others.
  void add(std::int64_t time, double value);
  void add(const Summed& later);
  /// That value was in force for so long.
  void hold(double value, std::int64_t time) { area += value * static_cast<double>(time), held += time; }
  /// Weighted by the time in which each value was in force, if any of it is known.
  double mean() const { return held > 0 ? area / static_cast<double>(held) : sum / count; }
};

/// Calls `visit(value, from, until)` for each value that was in force between two of these points, which are in order.
template <class Visit>
void each_hold(const Points& points, Visit visit) {
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto &one = points[i - 1], &next = points[i];
    if (!one.gap() && next.time > one.time && next.time - one.time <= kSilence) visit(one.value, one.time, next.time);
  }
}

/// Makes the buckets and the gaps of one series. Everything is added in order of time.
class Collector {
 public:
  /// `before`: the last point before the grid; `alive`: until when the series was observed at most.
  Collector(const Grid& grid, std::optional<Point> before, std::int64_t alive);

  /// Points outside of the grid are ignored.
  void add(const Point& point);
  /// Observed without a gap; lies in one bucket.
  void add(const Summed& sum);

  /// Fills buckets, gaps and the value before.
  void finish(SeriesAnswer& answer);

 private:
  void observed(std::int64_t from, std::int64_t to);
  void hold_until(std::int64_t time);
  void add_gap(std::int64_t from, std::int64_t to);

  Grid grid_;
  std::optional<Point> before_;
  std::int64_t alive_;
  std::vector<Summed> sums_;
  std::vector<Gap> gaps_;
  bool in_gap_ = false;
  std::int64_t since_ = 0;  ///< of the gap, or the last point
  double value_ = 0;        ///< of the last point
};

}  // namespace rubicon::history
