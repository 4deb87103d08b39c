#include "history/keeper.h"

#include <filesystem>
#include <fstream>

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
