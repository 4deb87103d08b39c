#include "history/open_points.h"

#include <algorithm>

#include "base/assert.h"
#include "history/point_codec.h"

namespace rubicon::history {

namespace {

constexpr std::size_t kTail = 32;

}  // namespace

void OpenPoints::add(const Point& point) {
  start_ = empty() ? point.time : std::min(start_, point.time);
  end_ = empty() ? point.time : std::max(end_, point.time);
  last_ = point;
  ++count_;
  tail_.push_back(point);
  if (tail_.size() < kTail) return;
  auto packed = pack_points(tail_);
  packed.shrink_to_fit();
  packed_.push_back(std::move(packed));
  tail_.clear();
}

void OpenPoints::clear() {
  *this = OpenPoints();
}

Points OpenPoints::all() const {
  Points points;
  points.reserve(count_);
  for (const auto& packed : packed_) {
    const auto some = unpack_points(packed);
    RUBICON_ASSERT(some);  // we packed it
    points.insert(points.end(), some->begin(), some->end());
  }
  points.insert(points.end(), tail_.begin(), tail_.end());
  return points;
}

std::vector<Points> take_blocks(Points& points, std::size_t most) {
  std::vector<Points> blocks;
  std::size_t begin = 0;
  std::int64_t start = 0, end = 0;
  for (std::size_t i = 0; i <= points.size(); ++i) {
    if (i > begin && i < points.size()) {
      start = std::min(start, points[i].time);
      end = std::max(end, points[i].time);
    }
    const bool full = i - begin >= most || (i > begin && end - start > kOpenBlock);
    if (full) {
      blocks.emplace_back(points.begin() + static_cast<std::ptrdiff_t>(begin),
                          points.begin() + static_cast<std::ptrdiff_t>(i));
      begin = i;
    }
    if (i == begin && i < points.size()) start = end = points[i].time;
  }
  points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(begin));
  return blocks;
}

}  // namespace rubicon::history
