#include "history/keeper.h"

#include <gtest/gtest.h>

#include <random>

#include "history/history_support.h"

namespace rubicon::history {
namespace {

constexpr const char* kOld = "proxy.wsn-1.7.sensor.light-1.value";

/// A store with a point each ten seconds, and a clock that runs while retention has its steps.
class RetentionTest : public testing::Test {
 protected:
  void fill(std::int64_t from, std::int64_t to, int series = 1) {
    for (int i = 0; i < series; ++i) {
      Points points;
      for (auto time = from; time < to; time += 10 * kSecond)
        points.push_back(
            {time, noise_ ? static_cast<double>(random_() % 1000) : static_cast<double>(time / kSecond % 3600)});
      ASSERT_TRUE(store_->write(batch_of(number_series(key(i)), points, to)));
      store_->forget_slots();
    }
    ASSERT_TRUE(store_->close_all());
  }
  static std::string key(int i) { return i == 0 ? kOld : "other." + std::to_string(i); }

  /// Each second of `span` is one of the machine's clock.
  std::vector<std::string> run(Retention& retention, std::int64_t wall_from, Duration span,
                               Duration every = std::chrono::seconds(60),
                               std::optional<std::uint64_t> free = std::nullopt) {
    std::vector<std::string> said;
    for (Duration passed{0}; passed <= span; passed += every) {
      const auto step =
          retention.step(SteadyTime(now_ + passed),
                         wall(wall_from) + std::chrono::duration_cast<std::chrono::microseconds>(passed), free);
      EXPECT_TRUE(step) << step.error().text;
      if (step && !step->empty()) said.push_back(*step);
    }
    now_ += span;
    return said;
  }
  std::int64_t first() { return points_of(*store_, kOld).front().time; }
  std::int64_t hours() { return *store_->database().number("SELECT count(*) FROM hour", "test"); }
  /// Of pages that are in use.
  std::int64_t used() {
    auto& database = store_->database();
    return 8192 * (*database.number("PRAGMA page_count", "t") - *database.number("PRAGMA freelist_count", "t"));
  }

  bool noise_ = false;  ///< values that cannot be packed well
  std::mt19937 random_{11};
  Folder folder_;
  std::unique_ptr<Store> store_ = opened(folder_ / "h");
  Duration now_{std::chrono::hours(5)};
};

TEST_F(RetentionTest, TurnsOldPointsIntoHoursAndRemovesOldHours) {
  fill(kBegin, kBegin + 10 * kDay);
  Retention retention(*store_, {std::chrono::hours(48), std::chrono::hours(7 * 24), 1'000'000'000});
  run(retention, kBegin + 10 * kDay, std::chrono::hours(1));
  EXPECT_GE(first(), kBegin + 8 * kDay - 2 * kHour);
  EXPECT_LE(first(), kBegin + 8 * kDay + kHour);
  EXPECT_NEAR(static_cast<double>(hours()), 5 * 24, 3);
  const auto past = answer(*store_, {{{OwnerId(6541), kOld}}, wall(kBegin + 4 * kDay), wall(kBegin + 5 * kDay), 24});
  ASSERT_TRUE(past);
  ASSERT_EQ(past->series[0].buckets.size(), 24U);
  EXPECT_EQ(past->series[0].buckets[3], (Bucket{wall(kBegin + 4 * kDay + 3 * kHour), 360, 0, 0, 3590, 1795, 3590}));
  EXPECT_TRUE(past->series[0].gaps.empty());
}

TEST_F(RetentionTest, OfBlocksInAnyOrderTheLatestPointIsTheLastOfItsHour) {
  const auto slot = number_series(kOld);
  const auto write = [&](std::vector<std::pair<int, double>> minutes) {
    Points points;
    for (const auto& [minute, value] : minutes) points.push_back({kBegin + minute * 60 * kSecond, value});
    ASSERT_TRUE(store_->write(batch_of(slot, points, kBegin + kHour)));
    store_->forget_slots();
    ASSERT_TRUE(store_->close_all());
  };
  write({{0, 1}, {50, 7}});
  write({{10, 2}, {20, 3}});  // written later, and ends earlier
  Retention retention(*store_, {std::chrono::hours(1), std::chrono::hours(7 * 24), 1'000'000'000});
  run(retention, kBegin + kDay, std::chrono::hours(1));
  write({{30, 4}});  // written when the others are summed up
  run(retention, kBegin + kDay + 2 * kHour, std::chrono::hours(1));
  const auto past = answer(*store_, {{{OwnerId(6541), kOld}}, wall(kBegin), wall(kBegin + kHour), 1});
  ASSERT_TRUE(past);
  EXPECT_EQ(past->series[0].buckets.at(0).last, 7);
  EXPECT_EQ(past->series[0].buckets.at(0).count, 5U);
  EXPECT_EQ(past->series[0].buckets.at(0).first, 1);
}

TEST_F(RetentionTest, AnswersTheSameAcrossTheBorder) {
  fill(kBegin, kBegin + 6 * kDay);
  const Question question{{{OwnerId(6541), kOld}}, wall(kBegin), wall(kBegin + 6 * kDay), 200};
  const auto before = answer(*store_, question);
  Retention retention(*store_, {std::chrono::hours(48), std::nullopt, 1'000'000'000});
  run(retention, kBegin + 6 * kDay, std::chrono::hours(1));
  const auto after = answer(*store_, question);
  ASSERT_TRUE(before && after);
  EXPECT_GT(hours(), 90);
  ASSERT_EQ(after->series[0].buckets.size(), before->series[0].buckets.size());
  for (std::size_t i = 0; i < before->series[0].buckets.size(); ++i) {
    auto one = before->series[0].buckets[i];
    EXPECT_NEAR(after->series[0].buckets[i].mean, one.mean, 0.01 * one.mean) << "of two blocks in one hour: nearly";
    one.mean = after->series[0].buckets[i].mean;
    EXPECT_EQ(after->series[0].buckets[i], one);
  }
}

TEST_F(RetentionTest, RemovesTheOldestDaysBeyondTheSize) {
  noise_ = true;
  fill(kBegin, kBegin + 10 * kDay, 5);
  const auto size = static_cast<std::uint64_t>(*store_->database().number("PRAGMA page_count", "test") * 8192);
  Retention retention(*store_, {std::nullopt, std::nullopt, size * 2 / 3});
  const auto said = run(retention, kBegin + 10 * kDay, std::chrono::hours(3));
  EXPECT_GE(said.size(), 3U);
  EXPECT_NE(said.front().find("the points before 2026-01-02 00:00 go"), std::string::npos) << said.front();
  EXPECT_GE(first(), kBegin + 3 * kDay - 2 * kHour);
  EXPECT_LE(first(), kBegin + 6 * kDay);
  EXPECT_EQ(points_of(*store_, kOld).back().time, kBegin + 10 * kDay - 10 * kSecond);
}

TEST_F(RetentionTest, LosesNothingToAClockThatIsAYearAheadForHours) {
  fill(kBegin, kBegin + 4 * kDay);
  Retention retention(*store_, {std::chrono::hours(5 * 24), std::nullopt, 1'000'000'000});
  run(retention, kBegin + 4 * kDay, std::chrono::hours(1));
  run(retention, kBegin + 370 * kDay, std::chrono::hours(5));
  EXPECT_EQ(first(), kBegin);
  run(retention, kBegin + 4 * kDay + 6 * kHour, std::chrono::hours(1));
  EXPECT_EQ(first(), kBegin);
  run(retention, kBegin - 361 * kDay, std::chrono::hours(3));
  EXPECT_EQ(first(), kBegin);
  EXPECT_EQ(retention.clock(), wall(kBegin - 361 * kDay) + std::chrono::hours(3));
}

TEST_F(RetentionTest, KeepsItsClockInTheFile) {
  fill(kBegin, kBegin + 4 * kDay);
  Retention first_run(*store_, {std::chrono::hours(5 * 24), std::nullopt, 1'000'000'000});
  run(first_run, kBegin + 4 * kDay, std::chrono::hours(1));
  store_.reset();
  store_ = opened(folder_ / "h");
  Retention second_run(*store_, {std::chrono::hours(5 * 24), std::nullopt, 1'000'000'000});
  run(second_run, kBegin + 370 * kDay, std::chrono::hours(2));
  EXPECT_EQ(first(), kBegin);
  // It follows in the end: the clock was right, and the machine was off for a year.
  run(second_run, kBegin + 370 * kDay, std::chrono::hours(93 * 24), std::chrono::minutes(30));
  EXPECT_TRUE(points_of(*store_, kOld).empty());
}

TEST_F(RetentionTest, ShortensOldSummariesAndKeepsNewPointsBeyondTheSize) {
  fill(kBegin, kBegin + kHour, 5);
  const auto points = points_of(*store_, kOld);
  // Two years of summaries of five series: more than the size alone.
  ASSERT_TRUE(store_->database().run(
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<17500) "
      "INSERT INTO hour(series,start,until,count,minimum,maximum,sum,last) SELECT "
      "s.id,1767225600000-n.i*3600000,1767225600000-n.i*3600000+3590000,360,i*0.1,i*0.2,i*0.3,i*0.7 FROM n, series s",
      "test"));
  Retention retention(*store_, {std::chrono::hours(30 * 24), std::chrono::hours(730 * 24), 1'000'000});
  const auto said = run(retention, kBegin + kHour, std::chrono::hours(13));
  EXPECT_EQ(points_of(*store_, kOld), points);
  EXPECT_LE(used(), 1'000'000);
  EXPECT_GT(hours(), 8'000);
  EXPECT_NE(said.front().find("the summaries of hours before 2024-01-03 00:00 go"), std::string::npos) << said.front();
}

TEST_F(RetentionTest, ShortensPointsAndSummariesInProportion) {
  noise_ = true;
  fill(kBegin, kBegin + 30 * kDay, 5);
  ASSERT_TRUE(store_->database().run(
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<16800) "
      "INSERT INTO hour(series,start,until,count,minimum,maximum,sum,last) SELECT "
      "s.id,1767225600000-n.i*3600000,1767225600000-n.i*3600000+3590000,360,i*0.1,i*0.2,i*0.3,i*0.7 FROM n, series s",
      "test"));
  const auto half = static_cast<std::uint64_t>(used() / 2);
  Retention retention(*store_, {std::chrono::hours(30 * 24), std::chrono::hours(730 * 24), half});
  run(retention, kBegin + 30 * kDay, std::chrono::hours(13));
  EXPECT_LE(used(), static_cast<std::int64_t>(half));
  const auto now = kBegin + 30 * kDay;
  const auto oldest_hour = *store_->database().number("SELECT min(start) FROM hour", "test");
  const auto raw_part = static_cast<double>(now - first()) / (30.0 * kDay);
  const auto hours_part = static_cast<double>(now - oldest_hour) / (730.0 * kDay);
  EXPECT_GT(raw_part, 0.3);
  EXPECT_NEAR(raw_part, hours_part, 0.08);
}

TEST_F(RetentionTest, RemovesOldTextsBeyondTheSize) {
  const Declaration series{{OwnerId(6541), "robot.pose"}, SeriesKind::kText, "", {}};
  for (int hour = 0; hour < 24; ++hour) {
    Batch batch{wall(kBegin + hour * kHour), {{0, series}}, {}, {}};
    for (int i = 0; i < 60; ++i)
      batch.texts.push_back(
          {0, kBegin + hour * kHour + i * kMinute, std::string(4000, static_cast<char>('a' + i % 20))});
    ASSERT_TRUE(store_->write(batch));
  }
  ASSERT_GT(used(), 5'000'000);
  Retention retention(*store_, {std::chrono::hours(30 * 24), std::nullopt, 2'000'000});
  run(retention, kBegin + kDay, std::chrono::hours(2));
  EXPECT_LE(used(), 2'000'000);
  EXPECT_GT(used(), 1'500'000);
  EXPECT_EQ(*store_->database().number("SELECT max(time) FROM text", "test"), kBegin + 24 * kHour - kMinute);
}

TEST_F(RetentionTest, KeepsTheTextInForceUntilItsSeriesIsGone) {
  const Declaration series{{OwnerId(6541), "robot.pose"}, SeriesKind::kText, "", {}};
  const auto write = [&](std::int64_t time, const std::string& text) {
    ASSERT_TRUE(store_->write(Batch{wall(time), {{0, series}}, {}, {{0, time, text}}}));
  };
  const auto before = [&](std::int64_t from) {
    const auto got = answer(*store_, {{series.name}, wall(from), wall(from + kHour), 100});
    EXPECT_TRUE(got);
    return got->series.at(0).text_before;
  };
  write(kBegin, "sits");
  write(kBegin + kHour, "stands");
  Retention retention(*store_, {std::chrono::hours(24), std::nullopt});
  run(retention, kBegin + kHour, std::chrono::hours(1));
  const auto late = kBegin + 100 * kHour;
  run(retention, late, std::chrono::hours(100));
  EXPECT_EQ(*store_->database().number("SELECT count(*) FROM text", "test"), 1);
  EXPECT_EQ(before(late), (TextValue{wall(kBegin + kHour), "stands"}));
  write(late + kHour, "");
  EXPECT_EQ(before(late + 2 * kHour), std::nullopt);
  run(retention, late + 100 * kHour, std::chrono::hours(200));
  EXPECT_EQ(*store_->database().number("SELECT count(*) FROM text", "test"), 0);
}

TEST_F(RetentionTest, KeepsAReserveOnADiskThatIsAlmostFull) {
  noise_ = true;
  fill(kBegin, kBegin + 10 * kDay, 5);
  const auto before = used();
  Retention retention(*store_, {std::nullopt, std::nullopt, 8'000'000'000});
  const auto said = run(retention, kBegin + 10 * kDay, std::chrono::hours(2), std::chrono::seconds(60), 0);
  ASSERT_FALSE(said.empty());
  EXPECT_NE(said.front().find("the disk is almost full"), std::string::npos) << said.front();
  EXPECT_LE(used(), before * 10 / 11 + 8192);
  EXPECT_GE(used(), before * 3 / 4);  // and not all
  EXPECT_EQ(points_of(*store_, kOld).back().time, kBegin + 10 * kDay - 10 * kSecond);
}

TEST_F(RetentionTest, FollowsAtOnceAfterAClockThatWasBehind) {
  fill(kBegin, kBegin + 4 * kDay);
  const RetentionRules rules{std::chrono::hours(5 * 24), std::nullopt, 1'000'000'000};
  {
    Retention good(*store_, rules);
    run(good, kBegin + 4 * kDay, std::chrono::hours(2));
  }
  {
    Retention reset(*store_, rules);
    run(reset, 5 * kMinute, std::chrono::hours(2));  // 1970
  }
  Retention again(*store_, rules);
  run(again, kBegin + 4 * kDay + 2 * kHour, std::chrono::minutes(2));
  EXPECT_EQ(again.clock(), wall(kBegin + 4 * kDay + 2 * kHour) + std::chrono::minutes(2));
  run(again, kBegin - 90 * kDay, std::chrono::hours(1));
  run(again, kBegin + 4 * kDay + 3 * kHour, std::chrono::minutes(70));
  EXPECT_EQ(again.clock(), wall(kBegin + 4 * kDay + 3 * kHour) + std::chrono::minutes(70));
}

TEST_F(RetentionTest, TakesTheFirstClockThatIsPlausible) {
  fill(kBegin, kBegin + 4 * kDay);
  Retention retention(*store_, {std::chrono::hours(24), std::nullopt, 1'000'000'000});
  run(retention, 5 * kMinute, std::chrono::hours(1));  // 1970
  run(retention, kBegin + 4 * kDay, std::chrono::minutes(70));
  EXPECT_GE(first(), kBegin + 3 * kDay - 2 * kHour);
}

TEST_F(RetentionTest, RemovesSeriesOfWhichNothingIsLeft) {
  fill(kBegin, kBegin + kHour, 3);
  Retention retention(*store_, {std::chrono::hours(24), std::chrono::hours(48)});
  // The slot of a source still names the series.
  ASSERT_TRUE(store_->write(batch_of(number_series(kOld), {{kBegin + kHour, 5}}, kBegin + kHour)));
  ASSERT_TRUE(store_->close_all());
  run(retention, kBegin + kHour, std::chrono::hours(1));
  EXPECT_EQ(store_->series().size(), 3U);
  const auto late = kBegin + 300 * kHour;
  run(retention, late, std::chrono::hours(200), std::chrono::minutes(1));
  EXPECT_EQ(hours(), 0);
  // The newest row stays, so that its id is not given again.
  EXPECT_EQ(store_->series().size(), 1U);
  EXPECT_FALSE(store_->find({OwnerId(6541), kOld}));
  Batch again{wall(late), {}, {{0, {late, 7}}}, {}};
  ASSERT_TRUE(store_->write(again));
  EXPECT_EQ(store_->series().size(), 2U);
  store_.reset();
  store_ = opened(folder_ / "h");
  EXPECT_EQ(store_->damaged(), 0U);
  EXPECT_EQ(values_of(*store_, kOld), (Points{{late, 7}}));
}

}  // namespace
}  // namespace rubicon::history
