#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rubicon/address.hpp"
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

/// A tuple whose values are kept over time.
struct SeriesName {
  OwnerId owner{};
  std::string key;

  friend bool operator==(const SeriesName&, const SeriesName&) = default;
  friend auto operator<=>(const SeriesName&, const SeriesName&) = default;
};

/// How the values of a series are stored. It is decided by the first value and stays.
enum class SeriesKind : std::uint8_t {
  kNumber,  ///< numbers
  kWords,   ///< few words: each value is the place of a word in `words`
  kText,    ///< texts and JSON, at most one a second
};

/// What is known of one series.
struct SeriesEntry {
  SeriesName name;
  SeriesKind kind = SeriesKind::kNumber;
  std::string unit{};                ///< `degC`; empty = none known
  std::vector<std::string> words{};  ///< of the kind kWords
  WallTime first{}, last{};          ///< times of the oldest and the newest value
};

/// A part of the list of all series, which is in the natural order of their names as `OWNER:KEY`.
struct SeriesRange {
  std::string after{};  ///< the name before the first one; empty = from the beginning
  std::size_t most = SIZE_MAX;
};

/// Longest list of series of one question, and most buckets of a series.
inline constexpr std::size_t kMaxAsked = 32;
inline constexpr std::size_t kMaxBuckets = 5000;
/// The texts of an answer take about so much at most; each series has the same share.
inline constexpr std::size_t kMaxTextBytes = 4'000'000;

struct Question {
  std::vector<SeriesName> series;
  WallTime from{}, to{};       ///< [from, to)
  std::size_t buckets = 1000;  ///< at most so many per series, 1 to kMaxBuckets
};

/// The values of one span of time. Buckets start at multiples of their width since 1970.
struct Bucket {
  WallTime time{};          ///< of the only value; otherwise the start of the bucket
  std::uint32_t count = 0;  ///< values, 1 or more
  double first = 0;
  double minimum = 0, maximum = 0;
  double mean = 0;  ///< weighted by the time of the bucket in which each value was in force, that from before included
  double last = 0;

  friend bool operator==(const Bucket&, const Bucket&) = default;
};

/// The point had no good value, or was not observed, from `from` until `to`.
struct Gap {
  WallTime from{}, to{};

  friend bool operator==(const Gap&, const Gap&) = default;
};

struct TextValue {
  WallTime time{};
  std::string text;

  friend bool operator==(const TextValue&, const TextValue&) = default;
};

struct NumberValue {
  WallTime time{};
  double value = 0;

  friend bool operator==(const NumberValue&, const NumberValue&) = default;
};

/// The past of one series. A series without values has neither buckets nor texts.
struct SeriesAnswer {
  SeriesName name;
  SeriesKind kind = SeriesKind::kNumber;
  std::string unit{};
  std::vector<std::string> words{};        ///< of the kind kWords: word number n is words[n]
  std::optional<NumberValue> before{};     ///< the value in force at the beginning, unless that was in a gap
  std::optional<TextValue> text_before{};  ///< the same, of the kind kText
  std::vector<Bucket> buckets{};           ///< those with values, by time
  std::vector<Gap> gaps{};                 ///< within the question, by time
  std::vector<TextValue> texts{};          ///< of the kind kText, the newest ones, by time; at most `buckets`
};

struct Answer {
  WallTime from{}, to{};
  std::chrono::milliseconds bucket{0};  ///< width; of a question about all times it is more than a Duration holds
  std::vector<SeriesAnswer> series;     ///< in the order of the question
};

/// What a series is, as its source says.
struct Declaration {
  SeriesName name;
  SeriesKind kind = SeriesKind::kNumber;
  std::string unit{};
  std::vector<std::string> words{};

  friend bool operator==(const Declaration&, const Declaration&) = default;
};

/// The place of a series in the numbering of one source, from 0.
using Slot = std::uint32_t;

struct SlotPoint {
  Slot slot = 0;
  Point point;
};

struct SlotText {
  Slot slot = 0;
  std::int64_t time = 0;  ///< milliseconds since 1970
  std::string text;
};

/// Memory of a point, and of a text besides its bytes, rounded up.
inline constexpr std::size_t kPointBytes = 32, kTextBytes = 64;
/// So much waits at most while nothing can be written: 250,000 points, or 2,000 long texts.
inline constexpr std::size_t kMaxWaitingCount = 8'000'000;

/// What is written in one transaction: all of it, or nothing.
struct Batch {
  WallTime time{};                                       ///< when it was made
  std::vector<std::pair<Slot, Declaration>> declared{};  ///< new and changed series
  std::vector<SlotPoint> points{};                       ///< in the order of their arrival
  std::vector<SlotText> texts{};

  bool empty() const { return declared.empty() && points.empty() && texts.empty(); }
  std::size_t size() const { return points.size() + texts.size(); }
  std::size_t bytes() const {
    auto sum = points.size() * kPointBytes;
    for (const auto& text : texts) sum += kTextBytes + text.text.size();
    return sum;
  }
};

}  // namespace rubicon::history
