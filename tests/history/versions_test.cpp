#include <fmt/format.h>
#include <gtest/gtest.h>

#include "history/history_support.h"

namespace rubicon::history {
namespace {

constexpr const char* kOldSeries = "proxy.wsn-1.7.sensor.light-1.value";

/// Version 1 did not know how long values were in force.
TEST(Versions, ReadsAndUpgradesFilesOfTheFirstVersion) {
  Folder folder;
  const Points points{{kBegin, 320}, {kBegin + 50 * kSecond, 40}, {kBegin + kMinute, 40}};
  {
    const auto store = opened(folder / "h");
    ASSERT_TRUE(store->write(batch_of(number_series(kOldSeries), points, kBegin + kMinute)));
    ASSERT_TRUE(store->close_all());
    auto& database = store->database();
    ASSERT_TRUE(
        database.run("INSERT INTO hour(series,start,until,count,minimum,maximum,sum,last) SELECT series,start-"
                     "86400000,start-86400000+60000,3,40,320,400,40 FROM block",
                     "test"));
    for (const auto* table : {"block", "hour"}) {
      for (const auto* column : {"first", "area", "held"})
        ASSERT_TRUE(database.run(fmt::format("ALTER TABLE {} DROP COLUMN {}", table, column).c_str(), "test"));
    }
    ASSERT_TRUE(database.run("PRAGMA user_version=1", "test"));
  }
  const auto bucket = [](Store& store, std::int64_t from) {
    const auto got = answer(store, {{{OwnerId(6541), kOldSeries}}, wall(from), wall(from + kHour), 1});
    EXPECT_TRUE(got && got->series[0].buckets.size() == 1U);
    return got ? got->series[0].buckets.at(0) : Bucket{};
  };
  const auto check = [&](Store& store) {
    const auto held = bucket(store, kBegin), summed = bucket(store, kBegin - kDay);
    EXPECT_EQ(held, (Bucket{wall(kBegin), 3, 320, 40, 320, (50 * 320 + 10 * 40) / 60.0, 40}));
    EXPECT_EQ(summed.last, 40);
    EXPECT_EQ(summed.count, 3U);
    EXPECT_NEAR(summed.first, 400.0 / 3, 1e-9) << "the mean stands for what was not kept";
  };
  check(*opened(folder / "h", sqlite::FileUse::kRead));
  const auto store = opened(folder / "h");
  check(*store);
  EXPECT_EQ(*store->database().number("PRAGMA user_version", "test"), 2);
  ASSERT_TRUE(store->write(batch_of(number_series(kOldSeries), {{kBegin + kHour, 1}}, kBegin + kHour)));
  EXPECT_TRUE(store->close_all());
}

}  // namespace
}  // namespace rubicon::history
