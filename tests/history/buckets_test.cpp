#include "history/buckets.h"

#include <gtest/gtest.h>

#include "history/history_support.h"

namespace rubicon::history {
namespace {

TEST(Grid, CoversTheTimeWithBucketsThatPeopleKnow) {
  const auto day = grid_of(kBegin, kBegin + kDay, 1000);
  EXPECT_EQ(day.width, 2 * kMinute);
  EXPECT_EQ(day.size(), 720U);
  EXPECT_EQ(grid_of(kBegin, kBegin + 15 * kMinute, 1000).width, kSecond);
  EXPECT_EQ(grid_of(kBegin, kBegin + 30 * kDay, 1000).width, kHour);
  EXPECT_EQ(grid_of(kBegin + 1, kBegin + 2, 1).width, 1);
}

TEST(Grid, HasTheSameWidthWhereverItBegins) {
  for (std::int64_t shift = 0; shift < kDay; shift += 777'777) {
    const auto grid = grid_of(kBegin + shift, kBegin + shift + 3 * kHour, 500);
    EXPECT_EQ(grid.width, 30 * kSecond);
    EXPECT_EQ(grid.from % grid.width, 0);
    EXPECT_LE(grid.from, kBegin + shift);
    EXPECT_GE(grid.to, kBegin + shift + 3 * kHour);
    EXPECT_LE(grid.size(), 500U);
  }
}

TEST(Grid, HasBucketsForAllTimesThatThereAre) {
  EXPECT_LE(grid_of(-kFurthest + 1, kFurthest - 1, 1).size(), 2U);
  EXPECT_LE(grid_of(-kFurthest + 1, kFurthest - 1, kMaxBuckets).size(), kMaxBuckets);
  EXPECT_EQ(grid_of(-1, 1, 1).size(), 2U);
}

SeriesAnswer collected(std::optional<Point> before, const Points& points, std::int64_t alive) {
  // One hour in minutes.
  Collector collector({0, kHour, kMinute}, before, alive);
  for (const auto& point : points) collector.add(point);
  SeriesAnswer answer;
  collector.finish(answer);
  return answer;
}

Gap gap(std::int64_t from, std::int64_t to) {
  return {wall(from), wall(to)};
}

TEST(Collector, AddsUpTheValuesOfABucket) {
  const auto answer = collected(Point{-kSecond, 7}, {{0, 2}, {10, 4}, {kMinute - 1, 3}, {kMinute, 9}}, kMinute);
  ASSERT_EQ(answer.buckets.size(), 2U);
  EXPECT_EQ(answer.buckets[0], (Bucket{wall(0), 3, 2, 2, 4, (10 * 2 + 59'989 * 4 + 1 * 3) / 60'000.0, 3}));
  EXPECT_EQ(answer.buckets[1], (Bucket{wall(kMinute), 1, 9, 9, 9, 9, 9}));
  ASSERT_TRUE(answer.before);
  EXPECT_EQ(answer.before->value, 7);
  EXPECT_TRUE(answer.gaps.empty());
}

/// A light that was at 320 lx for 50 s of the first minute, and at 40 lx since then.
TEST(Collector, WeighsTheMeanByTheTimeInForce) {
  const auto answer =
      collected(Point{-kSecond, 320}, {{50 * kSecond, 40}, {3 * kMinute + 30 * kSecond, 100}}, 10 * kMinute);
  ASSERT_EQ(answer.buckets.size(), 2U);
  EXPECT_DOUBLE_EQ(answer.buckets[0].mean, (50 * 320 + 10 * 40) / 60.0);
  EXPECT_DOUBLE_EQ(answer.buckets[1].mean, (30 * 40 + 30 * 100) / 60.0);
}

TEST(Collector, WhatIsUnknownHasNoWeight) {
  const auto answer = collected({}, {{30 * kSecond, 10}, {40 * kSecond, 20}, {50 * kSecond, kGap}}, kHour);
  ASSERT_EQ(answer.buckets.size(), 1U);
  EXPECT_DOUBLE_EQ(answer.buckets[0].mean, 15);
  // Silence is a gap, too.
  const auto silent = collected(Point{-kSecond, 1000}, {{30 * kMinute, 4}}, 30 * kMinute + 1);
  EXPECT_DOUBLE_EQ(silent.buckets.at(0).mean, 4);
}

TEST(Collector, OfABucketWithOneValueNamesItsTime) {
  const auto answer = collected({}, {{90 * kSecond, 5}}, 91 * kSecond);
  ASSERT_EQ(answer.buckets.size(), 1U);
  EXPECT_EQ(answer.buckets[0].time, wall(90 * kSecond));
}

TEST(Collector, ShowsGapsFromTheirMarkToTheNextValue) {
  const auto answer = collected(Point{0, 1}, {{5 * kMinute, kGap}, {6 * kMinute, kGap}, {8 * kMinute, 2}}, 9 * kMinute);
  EXPECT_EQ(answer.gaps, std::vector{gap(5 * kMinute, 8 * kMinute)});
}

TEST(Collector, ShowsSilenceAsAGap) {
  const auto answer = collected(Point{0, 1}, {{kMinute, 1}, {30 * kMinute, 2}, {40 * kMinute, 2}}, kHour);
  EXPECT_EQ(answer.gaps, std::vector{gap(kMinute, 30 * kMinute)});
}

/// As in a damaged file.
TEST(Collector, PointsOutOfOrderBeginNoGapWithinAnother) {
  const auto answer =
      collected(Point{0, 1}, {{kMinute, 1}, {30 * kMinute, 2}, {10 * kMinute, 2}, {40 * kMinute, 2}}, kHour);
  EXPECT_EQ(answer.gaps, std::vector{gap(kMinute, 30 * kMinute)});
}

TEST(Collector, WithoutAValueBeforeBeginsWithAGap) {
  EXPECT_EQ(collected({}, {{5 * kMinute, 1}}, 6 * kMinute).gaps, std::vector{gap(0, 5 * kMinute)});
  const auto old = collected(Point{-kHour, 1}, {{5 * kMinute, 1}}, 6 * kMinute);
  EXPECT_FALSE(old.before);
  EXPECT_EQ(old.gaps, std::vector{gap(0, 5 * kMinute)});
}

TEST(Collector, KnowsNothingOfTheTimeAfterTheLastBatch) {
  EXPECT_TRUE(collected(Point{0, 1}, {{kMinute, 1}}, 2 * kMinute).gaps.empty());
  EXPECT_EQ(collected(Point{0, 1}, {{kMinute, 1}}, kHour).gaps, std::vector{gap(kMinute, kHour)});
  EXPECT_EQ(collected(Point{0, 1}, {{kMinute, kGap}}, 10 * kMinute).gaps, std::vector{gap(kMinute, 10 * kMinute)});
}

TEST(Collector, TakesABlockAsOne) {
  Collector collector({0, kHour, 30 * kMinute}, {}, kHour);
  collector.add(Summed{kMinute, 20 * kMinute, 100, 0.25, -1, 1, 50, 0.5, 0.75 * 19 * kMinute, 19 * kMinute});
  collector.add(Point{21 * kMinute, 3});
  collector.add(Point{25 * kMinute, kGap});
  SeriesAnswer answer;
  collector.finish(answer);
  ASSERT_EQ(answer.buckets.size(), 1U);
  EXPECT_EQ(answer.buckets[0], (Bucket{wall(0), 101, 0.25, -1, 3, (0.75 * 19 + 0.5 * 1 + 3 * 4) / 24, 3}));
}

}  // namespace
}  // namespace rubicon::history
