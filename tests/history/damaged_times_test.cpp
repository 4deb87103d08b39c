#include "history/history_support.h"

namespace rubicon::history {
namespace {

constexpr const char* kDamagedKey = "proxy.wsn-1.7.sensor.light-1.value";

TEST(DamagedTimes, LeavesOutABlockWhosePointsAreNotWithinItsTimes) {
  Folder folder;
  const auto store = opened(folder / "h");
  ASSERT_TRUE(store->write(batch_of(number_series(kDamagedKey), {{kBegin, 1}, {kBegin + 5, 2}}, kBegin)));
  ASSERT_TRUE(store->close_all());
  ASSERT_TRUE(store->database().run("UPDATE block SET until=until-1", "test"));
  EXPECT_EQ(points_of(*store, kDamagedKey), Points{});
  EXPECT_EQ(store->damaged(), 1U);
}

TEST(DamagedTimes, ListsASeriesWithImpossibleTimes) {
  Folder folder;
  const auto store = opened(folder / "h");
  ASSERT_TRUE(store->write(batch_of(number_series(kDamagedKey), {{kBegin, 1}}, kBegin)));
  ASSERT_TRUE(
      store->database().run("INSERT INTO hour(series,start,until,count,minimum,maximum,sum,last) "
                            "VALUES(1,-9223372036854775808,9223372036854775807,1,1,1,1,1)",
                            "test"));
  const auto listed = list_series(*store, {std::nullopt, "**"});
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->at(0).first, wall(-kFurthest));
  EXPECT_EQ(listed->at(0).last, wall(kFurthest));
}

TEST(DamagedTimes, AnswersWithATextOfAnImpossibleTime) {
  Folder folder;
  const auto store = opened(folder / "h");
  const Declaration series{{OwnerId(6541), kDamagedKey}, SeriesKind::kText, {}, {}};
  ASSERT_TRUE(store->write({wall(kBegin), {{0, series}}, {}, {{0, kBegin, "now"}}}));
  ASSERT_TRUE(store->database().run("INSERT INTO text VALUES(1,-9223372036854775808,'long ago')", "test"));
  const auto found = answer(*store, {{series.name}, wall(kBegin), wall(kBegin + kHour), 10});
  ASSERT_TRUE(found) << found.error().text;
  ASSERT_TRUE(found->series.at(0).text_before);
  EXPECT_EQ(found->series[0].text_before->time, wall(-kFurthest));
  EXPECT_EQ(found->series[0].text_before->text, "long ago");
}

}  // namespace
}  // namespace rubicon::history
