#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "history/point.h"

namespace rubicon::history {

/// A block spans at most this, so that a search for blocks knows how far back to begin.
inline constexpr std::int64_t kLongestBlock = kDay;
/// A block is closed so long after its first point at the latest.
inline constexpr std::int64_t kOpenBlock = 2 * kHour;
inline constexpr std::size_t kBlockPoints = 1024;

/// The points of one series that are not in a block yet. Keeps the older ones packed: ten thousand series have some
/// millions of them.
class OpenPoints {
 public:
  void add(const Point& point);
  void clear();
  bool empty() const { return count_ == 0; }
  std::size_t size() const { return count_; }
  /// Earliest and latest time; points may arrive in any order.
  std::int64_t start() const { return start_; }
  std::int64_t end() const { return end_; }
  const Point& last() const { return last_; }  ///< that arrived
  /// All of them, in the order of their arrival.
  Points all() const;

 private:
  std::vector<Bytes> packed_;
  Points tail_;
  std::size_t count_ = 0;
  std::int64_t start_ = 0, end_ = 0;
  Point last_;
};

/// Takes the points of complete blocks away from the beginning of `points`: each has at most `most` points within
/// kOpenBlock. What stays is not complete.
std::vector<Points> take_blocks(Points& points, std::size_t most);

}  // namespace rubicon::history
