#include "history/keeper.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <new>

#include "history/history_support.h"

namespace rubicon::history {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;

constexpr const char* kKept = "proxy.wsn-1.7.sensor.light-1.value";

/// A keeper with a clock and a disk that the test sets.
class KeeperTest : public testing::Test {
 protected:
  Keeper::Report work(Points points, Duration later = seconds(1)) {
    now_ += later;
    return keeper().work(batch(std::move(points)), now_, wall_now());
  }
  Batch batch(Points points) const {
    return batch_of(number_series(kKept), std::move(points), to_milliseconds(wall_now()));
  }
  WallTime wall_now() const {
    return wall(kBegin) + std::chrono::duration_cast<std::chrono::microseconds>(now_.time_since_epoch());
  }
  Keeper& keeper() {
    if (!keeper_) keeper_ = std::make_unique<Keeper>(folder_ / "h", rules_, [this](const auto&) { return free_; });
    return *keeper_;
  }
  /// An index without the rows of its table, which is found when a row changes.
  void make_damage_that_the_check_does_not_find() {
    auto& database = keeper().store()->database();
    ::sqlite3_db_config(database.handle(), SQLITE_DBCONFIG_DEFENSIVE, 0, nullptr);
    ASSERT_TRUE(
        database.run("CREATE INDEX one ON series(unit) WHERE id<0; PRAGMA writable_schema=ON;"
                     "UPDATE sqlite_schema SET sql='CREATE INDEX one ON series(unit)' WHERE name='one'",
                     "test"));
    keeper_.reset();
  }
  std::size_t set_aside() {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      count += entry.path().filename().string().find(".damaged-") != std::string::npos ? 1U : 0U;
    return count;
  }

  Folder folder_;
  RetentionRules rules_{};
  std::optional<std::uint64_t> free_;
  SteadyTime now_{};
  std::unique_ptr<Keeper> keeper_;
};

TEST_F(KeeperTest, WritesTheLastBatchAlsoInAPause) {
  std::filesystem::create_directory(folder_ / "h");
  for (int i = 0; i < 10; ++i) work({{kBegin + i, 1}});
  EXPECT_FALSE(keeper().store());
  std::filesystem::remove(folder_ / "h");
  EXPECT_FALSE(work({{kBegin + 10, 1}}, Duration(0)).reason.empty());
  const auto report = keeper().finish(batch({{kBegin + 11, 1}}), now_, wall_now());
  EXPECT_EQ(report.reason, "");
  EXPECT_EQ(report.points, 12U);
  keeper_.reset();
  EXPECT_EQ(points_of(*opened(folder_ / "h"), kKept).size(), 12U);
}

TEST_F(KeeperTest, DropsABatchThatASoundFileDoesNotTake) {
  work({{kBegin, 1}});
  ASSERT_TRUE(keeper().store()->database().run("CREATE UNIQUE INDEX one ON journal(data)", "test"));
  work({{kBegin + 1, 2}});
  const auto failing = work({{kBegin + 1, 2}});
  EXPECT_EQ(set_aside(), 0U);
  EXPECT_EQ(failing.dropped, 1U);
  EXPECT_FALSE(failing.reason.empty());
  const auto next = work({{kBegin + 2, 3}}, minutes(1));
  EXPECT_EQ(next.reason, "");
  EXPECT_EQ(set_aside(), 0U);
  EXPECT_EQ(values_of(*keeper().store(), kKept), (Points{{kBegin, 1}, {kBegin + 1, 2}, {kBegin + 2, 3}}));
}

TEST_F(KeeperTest, LeavesASoundFileThatFailsToTakeABatch) {
  work({{kBegin, 1}});
  ASSERT_TRUE(keeper().store()->database().run(
      fmt::format("CREATE INDEX one ON journal(abs(CASE WHEN time>{} THEN -9223372036854775807-1 ELSE 0 END))",
                  to_milliseconds(wall_now()))
          .c_str(),
      "test"));
  const auto failing = work({{kBegin + 1, 2}});
  EXPECT_NE(failing.reason.find("integer overflow"), std::string::npos) << failing.reason;
  EXPECT_EQ(failing.unwritten, 1U);
  EXPECT_EQ(set_aside(), 0U);
  ASSERT_TRUE(keeper().store()->database().run("DROP INDEX one", "test"));
  EXPECT_EQ(work({{kBegin + 2, 3}}, minutes(1)).reason, "");
  EXPECT_EQ(values_of(*keeper().store(), kKept), (Points{{kBegin, 1}, {kBegin + 1, 2}, {kBegin + 2, 3}}));
}

TEST_F(KeeperTest, LeavesASoundFileWithoutOneOfItsTables) {
  work({{kBegin, 1}});
  keeper_.reset();
  auto other = sqlite::Database::open("test", folder_ / "h", sqlite::Database::Mode::kWrite).value();
  ASSERT_TRUE(other.run("ALTER TABLE hour RENAME TO hold; ALTER TABLE text RENAME TO hour", "test"));
  const auto failing = work({{kBegin + 1, 2}});
  EXPECT_NE(failing.reason.find("no such table: text"), std::string::npos) << failing.reason;
  EXPECT_EQ(set_aside(), 0U);
  ASSERT_TRUE(other.run("ALTER TABLE hour RENAME TO text; ALTER TABLE hold RENAME TO hour", "test"));
  EXPECT_EQ(work({{kBegin + 2, 3}}, minutes(1)).reason, "");
  EXPECT_EQ(values_of(*keeper().store(), kKept), (Points{{kBegin, 1}, {kBegin + 1, 2}, {kBegin + 2, 3}}));
}

TEST_F(KeeperTest, SetsAFileAsideWhoseDamageTheCheckDoesNotFind) {
  work({{kBegin, 1}});
  make_damage_that_the_check_does_not_find();
  EXPECT_EQ(work({{kBegin + 1, 2}}).reason, "");
  auto changed = batch({{kBegin + 2, 3}});
  changed.declared[0].second.unit = "K";
  now_ += seconds(1);
  const auto report = keeper().work(changed, now_, wall_now());
  EXPECT_EQ(report.reason, "");
  EXPECT_EQ(report.dropped, 0U);
  EXPECT_EQ(set_aside(), 1U);
  EXPECT_EQ(points_of(*keeper().store(), kKept), (Points{{kBegin + 2, 3}}));
}

TEST_F(KeeperTest, EndsTheCheckOfTheFileAndStillWritesTheLastBatch) {
  auto texts = batch({});
  texts.declared[0].second.kind = SeriesKind::kText;
  for (int i = 0; i < 5000; ++i) texts.texts.push_back({0, kBegin + i, "a text"});
  ASSERT_EQ(keeper().work(texts, now_, wall_now()).points, 5000U);
  keeper_.reset();
  keeper().end();
  EXPECT_NE(work({{kBegin, 1}}).reason.find("interrupted"), std::string::npos);
  EXPECT_FALSE(keeper().store());
  auto last = batch({{kBegin + 1, 2}});
  last.declared[0].second.name.key = "other";
  last.declared[0].first = last.points[0].slot = 1;
  const auto report = keeper().finish(last, now_, wall_now());
  EXPECT_EQ(report.points, 2U);
  keeper_.reset();
  EXPECT_EQ(points_of(*opened(folder_ / "h"), "other"), (Points{{kBegin + 1, 2}}));
}

TEST_F(KeeperTest, WritesTheLastBatchAlsoWhenItFindsDamage) {
  work({{kBegin, 1}});
  make_damage_that_the_check_does_not_find();
  work({{kBegin + 1, 2}});
  auto last = batch({{kBegin + 2, 3}});
  last.declared[0].second.unit = "K";
  keeper().end();
  const auto report = keeper().finish(last, now_, wall_now());
  EXPECT_EQ(report.reason, "");
  EXPECT_EQ(report.unwritten, 0U);
  EXPECT_EQ(set_aside(), 1U);
  EXPECT_EQ(points_of(*keeper().store(), kKept), (Points{{kBegin + 2, 3}}));
}

TEST_F(KeeperTest, GoesOnAfterATimeWithoutMemory) {
  work({{kBegin, 1}});
  bool is_scarce = true;
  keeper_ = std::make_unique<Keeper>(folder_ / "h", rules_, [&](const auto&) -> std::optional<std::uint64_t> {
    if (is_scarce) throw std::bad_alloc();
    return std::nullopt;
  });
  const auto failing = work({{kBegin + 1, 2}});
  EXPECT_NE(failing.reason.find("not enough memory"), std::string::npos) << failing.reason;
  EXPECT_EQ(failing.failures, 1U);
  is_scarce = false;
  EXPECT_EQ(work({{kBegin + 2, 3}}, minutes(1)).reason, "");
  EXPECT_EQ(values_of(*keeper().store(), kKept), (Points{{kBegin, 1}, {kBegin + 1, 2}, {kBegin + 2, 3}}));
  EXPECT_EQ(set_aside(), 0U);
}

TEST_F(KeeperTest, DoesNotOpenAFileAtTheEndIfNothingWaits) {
  std::ignore = keeper().finish({}, now_, wall_now());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "h"));
}

TEST_F(KeeperTest, DropsABatchThatIsTooLargeForTheFile) {
  work({{kBegin, 1}});
  auto* file = keeper().store()->database().handle();
  const auto usual = ::sqlite3_limit(file, SQLITE_LIMIT_LENGTH, 20);
  const auto failing = work({{kBegin + 1, 2.5}, {kBegin + 7, 1234.75}, {kBegin + 9, 0.123456}});
  EXPECT_EQ(failing.dropped, 3U);
  ::sqlite3_limit(file, SQLITE_LIMIT_LENGTH, usual);
  EXPECT_EQ(work({{kBegin + 20, 3}}, minutes(1)).reason, "");
  EXPECT_EQ(points_of(*keeper().store(), kKept), (Points{{kBegin, 1}, {kBegin + 20, 3}}));
}

TEST_F(KeeperTest, LeavesAFileThatIsNoDatabase) {
  std::ofstream(folder_ / "h") << std::string(3000, 'n');
  const auto report = work({{kBegin, 1}});
  EXPECT_NE(report.reason.find("is not an SQLite database"), std::string::npos) << report.reason;
  EXPECT_EQ(std::filesystem::file_size(folder_ / "h"), 3000U);
  EXPECT_EQ(set_aside(), 0U);
}

TEST_F(KeeperTest, RemovesWhatIsOldestBeforeTheDiskIsFull) {
  free_ = 1'000'000'000;
  for (std::int64_t hour = 0; hour < 200; ++hour) {
    Points points;
    for (std::int64_t i = 0; i < 3600; ++i)
      points.push_back({kBegin + hour * kHour + i * kSecond, static_cast<double>(i * 7919 % 1000) + 0.123456});
    work(points, std::chrono::hours(1));
  }
  const auto first = [&] { return points_of(*keeper().store(), kKept).front().time; };
  EXPECT_EQ(first(), kBegin);
  free_ = 0;
  for (int i = 0; i < 60; ++i) work({}, minutes(1));
  EXPECT_GT(first(), kBegin + 12 * kHour);
  EXPECT_LT(first(), kBegin + 60 * kHour);
}

}  // namespace
}  // namespace rubicon::history
