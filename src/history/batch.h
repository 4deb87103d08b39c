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

/// What is written in one transaction: all of it, or nothing.
struct Batch {
  WallTime time{};                                       ///< when it was made
  std::vector<std::pair<Slot, Declaration>> declared{};  ///< new and changed series
  std::vector<SlotPoint> points{};                       ///< in the order of their arrival
  std::vector<SlotText> texts{};

  bool empty() const { return declared.empty() && points.empty() && texts.empty(); }
  std::size_t size() const { return points.size() + texts.size(); }
};

}  // namespace rubicon::history
