#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/time.hpp"

namespace rubicon::history {

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

}  // namespace rubicon::history
