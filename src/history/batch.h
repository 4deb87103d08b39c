#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "history/answer.h"
#include "history/point.h"

namespace rubicon::history {

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
inline constexpr std::size_t kMostWaiting = 8'000'000;

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
