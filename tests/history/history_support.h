#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "history/past.h"
#include "history/store.h"
#include "support/folder.h"

namespace rubicon::history {

using support::Folder;

/// 2026-01-01T00:00:00Z, as the virtual clock begins.
inline constexpr std::int64_t kBegin = 1'767'225'600'000;

inline WallTime wall(std::int64_t milliseconds) {
  return from_milliseconds(milliseconds);
}

inline std::unique_ptr<Store> opened(const std::string& path, sqlite::FileUse use = sqlite::FileUse::kOwn) {
  auto store = Store::open(path, use, true);
  EXPECT_TRUE(store) << store.error().text;
  return store ? std::move(*store) : nullptr;
}

inline Declaration number_series(std::string key) {
  return {{OwnerId(6541), std::move(key)}, SeriesKind::kNumber, "degC", {}};
}

/// A batch of points of one series, at the slot 0.
inline Batch batch_of(const Declaration& series, Points points, std::int64_t now) {
  Batch batch{wall(now), {{0, series}}, {}, {}};
  for (const auto& point : points) batch.points.push_back({0, point});
  return batch;
}

/// All points of a series, in the order of time.
inline Points points_of(Store& store, const std::string& key, std::int64_t from = -kFurthest,
                        std::int64_t to = kFurthest) {
  Points points;
  const auto row = store.find({OwnerId(6541), key});
  if (!row) return points;
  const auto done = each_point(store, *row, from, to, [&](const Point& point) {
    points.push_back(point);
    return true;
  });
  EXPECT_TRUE(done) << done.error().text;
  return points;
}

/// Without the marks of gaps.
inline Points values_of(Store& store, const std::string& key) {
  auto points = points_of(store, key);
  std::erase_if(points, [](const Point& point) { return point.gap(); });
  return points;
}

}  // namespace rubicon::history
