#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "history/blocks.h"
#include "history/history_support.h"

namespace rubicon::history {
namespace {

void expect_same(const Points& points) {
  BlockCodec codec;
  const auto back = codec.decode(codec.encode(points));
  ASSERT_TRUE(back) << back.error().text;
  EXPECT_EQ(*back, points);
}

/// A walk in steps of 10^-digits with jitter, gaps and sometimes a jump of the clock.
Points random_points(std::mt19937& random, std::size_t count, int digits) {
  const auto chance = [&](int most) { return static_cast<int>(random() % static_cast<unsigned>(most)) == 0; };
  Points points;
  std::int64_t time = kBegin, whole = static_cast<std::int64_t>(random() % 100'000);
  for (std::size_t i = 0; i < count; ++i) {
    time += 1000 + static_cast<std::int64_t>(random() % 7) - 3;
    if (chance(200)) time += 365 * kDay;
    if (chance(200)) time -= 365 * kDay;
    whole += static_cast<std::int64_t>(random() % 21) - 10;
    points.push_back({time, chance(20) ? kGap : static_cast<double>(whole) / std::pow(10.0, digits)});
  }
  return points;
}

TEST(BlockCodec, LosesNothingOfDecimalNumbers) {
  std::mt19937 random(17);
  for (int digits = 0; digits <= 9; ++digits) {
    for (const std::size_t count : {0U, 1U, 2U, 31U, 360U, 1024U}) expect_same(random_points(random, count, digits));
  }
}

TEST(BlockCodec, LosesNothingOfAnyDoubles) {
  std::mt19937_64 random(18);
  Points points;
  for (int i = 0; i < 1000; ++i) {
    double value = 0;
    do {
      value = std::bit_cast<double>(random());
    } while (std::isnan(value));
    points.push_back({kBegin + i, value});
  }
  points.push_back({kBegin, std::numeric_limits<double>::infinity()});
  points.push_back({kBegin, kGap});
  points.push_back({kBegin, std::numeric_limits<double>::denorm_min()});
  expect_same(points);
}

TEST(BlockCodec, KeepsLargeNumbersBesideSmallFractions) {
  expect_same({{0, 0.000000001}, {1, 9007199254740991.0}, {2, -9007199254740991.0}});
  expect_same({{-kFurthest, 1e300}, {kFurthest, -1e-300}, {0, 0.1}});
  expect_same({{5, kGap}, {5, kGap}, {6, kGap}});
}

TEST(BlockCodec, OfASensorWithOneDigitTakesLessThanTwoBytesAPoint) {
  std::mt19937 random(3);
  Points points;
  double value = 215;
  for (int i = 0; i < 1024; ++i) {
    value += static_cast<double>(random() % 3) - 1;
    points.push_back({kBegin + i * 1000 + static_cast<std::int64_t>(random() % 5), value / 10});
  }
  EXPECT_LT(BlockCodec().encode(points).size(), points.size() * 2);
}

TEST(BlockCodec, RefusesWhatIsDamaged) {
  std::mt19937 random(5);
  BlockCodec codec;
  const auto points = random_points(random, 300, 1);
  const auto good = codec.encode(points);
  for (std::size_t cut = 0; cut < good.size(); ++cut) EXPECT_FALSE(codec.decode(ByteView(good).first(cut)));
  // The check sum of zstd covers what it packed.
  for (std::size_t i = 1; i < good.size(); ++i) {
    auto bad = good;
    bad[i] ^= 0x10U;
    if (const auto back = codec.decode(bad)) {
      EXPECT_EQ(*back, points);
    }
  }
}

TEST(BlockCodec, RefusesACountBeyondItsBytes) {
  Bytes list{1};
  put_number(list, 60'000);
  EXPECT_FALSE(unpack_points(list));
  list = {15};
  put_number(list, 2);
  put_signed(list, 0);
  put_signed(list, 0);
  EXPECT_FALSE(unpack_points(list));
  EXPECT_FALSE(unpack_points(Bytes{12, 0, 0}));
  EXPECT_FALSE(unpack_points({}));
}

TEST(OpenPoints, TakesBlocksThatAreFullOrSpanTwoHours) {
  Points points;
  for (int i = 0; i < 2500; ++i) points.push_back({kBegin + i * kSecond, 1.0 * i});
  auto blocks = take_blocks(points, kBlockPoints);
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[1].front().value, 1024);
  EXPECT_EQ(points.size(), 2500U - 2048);
  points = {{0, 1}, {kHour, 2}, {2 * kHour, 3}, {2 * kHour + 1, 4}, {-kHour, 5}};
  blocks = take_blocks(points, kBlockPoints);
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[0].size(), 3U);
  EXPECT_EQ(blocks[1].size(), 1U);
  EXPECT_EQ(points.size(), 1U);
}

TEST(OpenPoints, KeepsAllThatWasAdded) {
  std::mt19937 random(8);
  OpenPoints open;
  const auto points = random_points(random, 777, 2);
  auto start = points[0].time, end = start;
  for (const auto& point : points) {
    open.add(point);
    start = std::min(start, point.time);
    end = std::max(end, point.time);
  }
  EXPECT_EQ(open.all(), points);
  EXPECT_EQ(open.size(), points.size());
  EXPECT_EQ(open.start(), start);
  EXPECT_EQ(open.end(), end);
  open.clear();
  EXPECT_TRUE(open.empty());
}

}  // namespace
}  // namespace rubicon::history
