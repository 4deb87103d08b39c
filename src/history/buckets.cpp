#include "history/buckets.h"

#include <algorithm>
#include <array>

namespace rubicon::history {

namespace {

constexpr std::array<std::int64_t, 29> kWidths{1,
                                               2,
                                               5,
                                               10,
                                               20,
                                               50,
                                               100,
                                               200,
                                               500,
                                               kSecond,
                                               2 * kSecond,
                                               5 * kSecond,
                                               10 * kSecond,
                                               15 * kSecond,
                                               30 * kSecond,
                                               kMinute,
                                               2 * kMinute,
                                               5 * kMinute,
                                               10 * kMinute,
                                               15 * kMinute,
                                               30 * kMinute,
                                               kHour,
                                               2 * kHour,
                                               3 * kHour,
                                               6 * kHour,
                                               12 * kHour,
                                               kDay,
                                               2 * kDay,
                                               7 * kDay};

Grid grid_with(std::int64_t from, std::int64_t to, std::int64_t width) {
  return {floor_to(from, width), floor_to(to + width - 1, width), width};
}

std::int64_t width_of(const Summed& sum) {
  return sum.end - sum.start;
}

}  // namespace

Grid grid_of(std::int64_t from, std::int64_t to, std::size_t buckets) {
  for (const auto width : kWidths) {
    if (const auto grid = grid_with(from, to, width); grid.size() <= buckets) return grid;
  }
  for (auto width = 2 * kWidths.back();; width *= 2) {
    // A span across 1970 has two buckets at least.
    const auto grid = grid_with(from, to, width);
    if (grid.size() <= std::max<std::size_t>(buckets, 2)) return grid;
  }
}

void Summed::add(std::int64_t time, double value) {
  if (count == 0) {
    start = time;
    first = minimum = maximum = value;
  }
  end = time;
  ++count;
  minimum = std::min(minimum, value);
  maximum = std::max(maximum, value);
  sum += value;
  last = value;
}

void Summed::add(const Summed& later) {
  if (later.count == 0) return;
  area += later.area;
  held += later.held;
  if (count == 0) {
    start = later.start;
    first = later.first, minimum = later.minimum, maximum = later.maximum;
  }
  end = later.end;
  count += later.count;
  minimum = std::min(minimum, later.minimum);
  maximum = std::max(maximum, later.maximum);
  sum += later.sum;
  last = later.last;
}

Collector::Collector(const Grid& grid, std::optional<Point> before, std::int64_t alive)
    : grid_(grid), alive_(alive), sums_(grid.size()) {
  if (before && !before->gap() && grid.from - before->time <= kSilence) before_ = before;
  in_gap_ = !before_;
  since_ = before_ ? before_->time : grid.from;
  value_ = before_ ? before_->value : 0;
}

void Collector::add(const Point& point) {
  if (!grid_.contains(point.time)) return;
  if (!point.gap()) {
    observed(point.time, point.time);
    sums_[grid_.place(point.time)].add(point.time, point.value);
    value_ = point.value;
  } else if (!in_gap_) {
    observed(point.time, point.time);
    in_gap_ = true;
  }
}

void Collector::add(const Summed& sum) {
  if (sum.count == 0 || !grid_.contains(sum.start)) return;
  observed(sum.start, sum.end);
  sums_[grid_.place(sum.start)].add(sum);
  value_ = sum.last;
}

/// The value of the last point, in all buckets of the time since then.
void Collector::hold_until(std::int64_t time) {
  auto from = std::max(since_, grid_.from);
  time = std::min(time, grid_.to);
  while (from < time) {
    const auto place = grid_.place(from);
    const auto end = std::min(time, grid_.from + static_cast<std::int64_t>(place + 1) * grid_.width);
    sums_[place].hold(value_, end - from);
    from = end;
  }
}

void Collector::observed(std::int64_t from, std::int64_t to) {
  if (in_gap_ || from - since_ > kSilence) {
    add_gap(since_, from);
  } else {
    hold_until(from);
  }
  in_gap_ = false;
  since_ = std::max({since_, from, to});  // what a damaged file has out of order begins no gap within another
}

/// A gap shorter than a bucket cannot be seen, and there may be millions.
void Collector::add_gap(std::int64_t from, std::int64_t to) {
  from = std::max(from, grid_.from);
  to = std::min(to, grid_.to);
  if (to - from >= grid_.width) gaps_.push_back({from_milliseconds(from), from_milliseconds(to)});
}

void Collector::finish(SeriesAnswer& answer) {
  const auto end = std::min(grid_.to, std::max(alive_, since_));
  if (in_gap_ || end - since_ > kSilence) {
    add_gap(since_, end);
  } else {
    hold_until(end);
  }
  if (before_) answer.before = NumberValue{from_milliseconds(before_->time), before_->value};
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const auto& sum = sums_[i];
    if (sum.count == 0) continue;
    const auto start = grid_.from + static_cast<std::int64_t>(i) * grid_.width;
    const bool single = sum.count == 1 && width_of(sum) == 0;
    answer.buckets.push_back({from_milliseconds(single ? sum.start : start), sum.count, sum.first, sum.minimum,
                              sum.maximum, sum.mean(), sum.last});
  }
  answer.gaps = std::move(gaps_);
}

}  // namespace rubicon::history
