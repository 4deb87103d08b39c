#include "history/store.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <new>
#include <random>
#include <set>

#include "history/history_support.h"

namespace rubicon::history {
namespace {

using testing::HasSubstr;

constexpr const char* kKey = "proxy.wsn-1.7.sensor.light-1.value";

/// The mean of what was in force from `from` until `to`, by looking at each point.
double naive_mean(const Points& points, std::int64_t from, std::int64_t to, std::int64_t alive) {
  double area = 0, held = 0, sum = 0, count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].gap()) continue;
    const auto next = i + 1 < points.size() ? points[i + 1].time : std::max(alive, points[i].time);
    if (points[i].time >= from && points[i].time < to) sum += points[i].value, count += 1;
    const auto begin = std::max(from, points[i].time), end = std::min(to, next);
    if (next - points[i].time > kSilence || end <= begin) continue;
    area += points[i].value * static_cast<double>(end - begin);
    held += static_cast<double>(end - begin);
  }
  return held > 0 ? area / held : sum / count;
}

/// What a question has to answer of a list of points, by looking at each of them.
SeriesAnswer naive_answer(const Points& points, const Grid& grid, std::int64_t alive) {
  std::map<std::int64_t, Points> buckets;
  for (const auto& point : points) {
    if (!point.gap() && point.time >= grid.from && point.time < grid.to)
      buckets[floor_to(point.time, grid.width)].push_back(point);
  }
  SeriesAnswer answer;
  for (const auto& [start, some] : buckets) {
    const auto low = [](const Point& a, const Point& b) { return a.value < b.value; };
    answer.buckets.push_back(
        {wall(some.size() == 1 ? some[0].time : start), static_cast<std::uint32_t>(some.size()), some.front().value,
         std::min_element(some.begin(), some.end(), low)->value, std::max_element(some.begin(), some.end(), low)->value,
         naive_mean(points, start, std::min(start + grid.width, grid.to), alive), some.back().value});
  }
  return answer;
}

void expect_equal(const SeriesAnswer& answer, const SeriesAnswer& expected) {
  ASSERT_EQ(answer.buckets.size(), expected.buckets.size());
  for (std::size_t i = 0; i < answer.buckets.size(); ++i) {
    const auto &one = answer.buckets[i], &other = expected.buckets[i];
    EXPECT_EQ(one.time, other.time);
    EXPECT_EQ(one.count, other.count);
    EXPECT_EQ(one.first, other.first);
    EXPECT_EQ(one.minimum, other.minimum);
    EXPECT_EQ(one.maximum, other.maximum);
    EXPECT_EQ(one.last, other.last);
    // What was in force before the first one is looked for in the latest blocks only; what follows the last one is not.
    if (i == 0 || i + 1 == answer.buckets.size()) continue;
    EXPECT_NEAR(one.mean, other.mean, 1e-9 * std::max(1.0, std::abs(other.mean)))
        << i << " of " << answer.buckets.size();
  }
}

/// Series that run at different paces, with gaps, jumps of the clock and late values, beside what was written.
class Model {
 public:
  explicit Model(unsigned seed) : random_(seed) {
    for (int i = 0; i < 6; ++i) {
      series_.push_back(number_series("proxy.dummy.d" + std::to_string(i) + ".sensor.light-1.value"));
      pace_.push_back(std::int64_t{100} << (3 * i));
    }
  }

  Batch next() {
    now_ += 1 + below(60 * kSecond);
    if (below(100) == 0) now_ += kDay;
    if (below(200) == 0) now_ += 365 * kDay;
    if (below(200) == 0) now_ -= 365 * kDay;
    Batch batch{wall(now_), {}, {}, {}};
    for (Slot slot = 0; slot < series_.size(); ++slot) {
      batch.declared.emplace_back(slot, series_[slot]);
      for (auto left = below(60 * kSecond / pace_[slot] + 2); left > 0; --left) {
        const auto late = below(50) == 0 ? below(3 * kHour) : 0;
        const auto value = below(40) == 0 ? kGap : static_cast<double>(below(1000)) / 10;
        const auto time = now_ - left * pace_[slot] - late;
        if (used_.emplace(slot, time).second) batch.points.push_back({slot, {time, value}});
      }
    }
    return batch;
  }
  void written(const Batch& batch) {
    for (const auto& [slot, point] : batch.points) all_[slot].push_back(point);
  }
  const std::vector<Declaration>& series() const { return series_; }
  Points sorted(Slot slot) {
    auto points = all_[slot];
    std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.time < b.time; });
    return points;
  }
  std::int64_t now() const { return now_; }
  std::int64_t below(std::int64_t most) {
    return static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(std::max<std::int64_t>(most, 1)));
  }

 private:
  std::mt19937_64 random_;
  std::int64_t now_ = kBegin;
  std::vector<Declaration> series_;
  std::vector<std::int64_t> pace_;
  std::map<Slot, Points> all_;
  std::set<std::pair<Slot, std::int64_t>> used_;  ///< no two points have one time: their order would be open
};

Points without_gaps(Points points) {
  std::erase_if(points, [](const Point& point) { return point.gap(); });
  return points;
}

TEST(Store, GivesBackWhatWasWrittenAcrossRestarts) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Folder folder;
    Model model(seed);
    auto store = opened(folder / "h");
    for (int step = 0; step < 400; ++step) {
      if (model.below(60) == 0) {
        store.reset();
        store = opened(folder / "h");
      }
      if (model.below(100) == 0) {
        ASSERT_TRUE(store->close_all());
      }
      const auto batch = model.next();
      const auto done = store->write(batch);
      ASSERT_TRUE(done) << done.error().text;
      model.written(batch);
    }
    for (Slot slot = 0; slot < model.series().size(); ++slot) {
      const auto expected = without_gaps(model.sorted(slot));
      EXPECT_EQ(values_of(*store, model.series()[slot].name.key), expected);
    }
    EXPECT_EQ(store->damaged(), 0U);
  }
}

TEST(Store, AnswersAsOneThatLooksAtEachPoint) {
  Folder folder;
  Model model(99);
  auto store = opened(folder / "h");
  std::vector<std::int64_t> times;
  for (int step = 0; step < 600; ++step) {
    const auto batch = model.next();
    ASSERT_TRUE(store->write(batch));
    model.written(batch);
    times.push_back(model.now());
  }
  for (int i = 0; i < 300; ++i) {
    const auto slot = static_cast<Slot>(model.below(6));
    const auto from = times[static_cast<std::size_t>(model.below(600))] - model.below(kHour);
    const auto to = from + 1 + (std::int64_t{1} << model.below(36));
    const auto buckets = static_cast<std::size_t>(1 + model.below(1000));
    const auto got = answer(*store, {{model.series()[slot].name}, wall(from), wall(to), buckets});
    ASSERT_TRUE(got) << got.error().text;
    expect_equal(got->series[0], naive_answer(model.sorted(slot), grid_of(from, to, buckets), store->alive()));
  }
}

TEST(Store, KeepsItsFileToItsUserAndGroupAndRefusesLinks) {
  Folder folder;
  opened(folder / "h").reset();
  struct stat about {};
  ASSERT_EQ(::stat((folder / "h").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0640U);
  std::filesystem::create_symlink(folder / "h", folder / "link");
  const auto linked = Store::open(folder / "link", sqlite::FileUse::kOwn, true);
  ASSERT_FALSE(linked);
  EXPECT_EQ(linked.error().code, ErrorCode::kRefused);
  EXPECT_THAT(linked.error().text, HasSubstr("symbolic link"));
}

TEST(Store, IsWrittenByOneAndReadByOthers) {
  Folder folder;
  auto store = opened(folder / "h");
  ASSERT_TRUE(store->write(batch_of(number_series(kKey), {{kBegin, 1}, {kBegin + 1, 2}}, kBegin)));
  const auto second = Store::open(folder / "h", sqlite::FileUse::kOwn, true);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kBusy);
  auto reader = opened(folder / "h", sqlite::FileUse::kRead);
  EXPECT_EQ(points_of(*reader, kKey), (Points{{kBegin, 1}, {kBegin + 1, 2}}));
}

TEST(Store, ShowsAReaderWhatWasThereWhenItWasOpened) {
  Folder folder;
  auto store = opened(folder / "h");
  const auto series = number_series(kKey);
  Points written;
  for (std::int64_t i = 0; i < 300; ++i) written.push_back({kBegin + i * kSecond, static_cast<double>(i)});
  ASSERT_TRUE(store->write(batch_of(series, written, kBegin + 300 * kSecond)));
  auto reader = opened(folder / "h", sqlite::FileUse::kRead);
  Points more;
  for (std::int64_t i = 300; i < 2000; ++i) more.push_back({kBegin + i * kSecond, static_cast<double>(i)});
  ASSERT_TRUE(store->write(batch_of(series, more, kBegin + 2000 * kSecond)));
  ASSERT_GT(*store->database().number("SELECT count(*) FROM block", "test"), 0);
  EXPECT_EQ(points_of(*reader, kKey), written);  // none of them twice
  EXPECT_EQ(points_of(*opened(folder / "h", sqlite::FileUse::kRead), kKey).size(), 2000U);
}

TEST(Store, TakesTheFirstPointsOfManySeriesAtOnce) {
  Folder folder;
  auto store = opened(folder / "h");
  constexpr Slot kSeries = 20'000;
  std::mt19937_64 random(3);
  Batch batch{wall(kBegin + kHour), {}, {}, {}};
  for (Slot slot = 0; slot < kSeries; ++slot) {
    batch.declared.emplace_back(slot, number_series("s." + std::to_string(slot)));
    for (std::int64_t i = 0; i < 25; ++i)
      batch.points.push_back({slot, {kBegin + i * kMinute, std::bit_cast<double>(random() >> 2U)}});
  }
  const auto done = store->write(batch);
  ASSERT_TRUE(done) << done.error().text;
  store.reset();
  store = opened(folder / "h");
  EXPECT_EQ(store->damaged(), 0U);
  for (Slot slot = 0; slot < kSeries; slot += 999) {
    const auto points = points_of(*store, "s." + std::to_string(slot));
    ASSERT_EQ(points.size(), 25U);
    EXPECT_EQ(points[24], batch.points[slot * std::size_t{25} + 24].point);
  }
  EXPECT_GT(*store->database().number("SELECT count(*) FROM journal", "test"), 3);
  // Closing blocks still makes room in the journal.
  ASSERT_TRUE(store->close_all());
  EXPECT_EQ(points_of(*store, "s.7").size(), 25U);
}

TEST(Store, IsNotCreatedWhereItMustExist) {
  Folder folder;
  const auto store = Store::open(folder / "typo", sqlite::FileUse::kOwn, true, false);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Store, AnswersWithABoundedAmountOfText) {
  Folder folder;
  auto store = opened(folder / "h");
  const Declaration series{{OwnerId(6541), "robot.pose"}, SeriesKind::kText, "", {}};
  Batch batch{wall(kBegin), {{0, series}}, {}, {}};
  for (int i = 0; i < 3000; ++i) batch.texts.push_back({0, kBegin + i, std::string(4000, 'x')});
  ASSERT_TRUE(store->write(batch));
  const auto got = answer(*store, {{series.name, series.name}, wall(kBegin), wall(kBegin + kHour), 5000});
  ASSERT_TRUE(got);
  for (const auto& one : got->series) {
    EXPECT_LE(one.texts.size(), 500U);
    EXPECT_GT(one.texts.size(), 450U);
    EXPECT_EQ(one.texts.back().time, wall(kBegin + 2999));
  }
}

TEST(Store, MarksAGapWhereTheWriterBeforeEnded) {
  Folder folder;
  ASSERT_TRUE(opened(folder / "h")->write(batch_of(number_series(kKey), {{kBegin, 1}}, kBegin + 500)));
  auto store = opened(folder / "h");
  ASSERT_TRUE(store->write(batch_of(number_series(kKey), {{kBegin + kHour, 2}}, kBegin + kHour)));
  EXPECT_EQ(points_of(*store, kKey), (Points{{kBegin, 1}, {kBegin + 501, kGap}, {kBegin + kHour, 2}}));
}

TEST(Store, KeepsABatchWholeOrNotAtAll) {
  Folder folder;
  auto store = opened(folder / "h");
  ASSERT_TRUE(store->write(batch_of(number_series(kKey), {{kBegin, 1}}, kBegin)));
  ASSERT_TRUE(store->database().run("CREATE TABLE hold AS SELECT * FROM journal; DROP TABLE journal", "test"));
  Batch batch = batch_of(number_series("other.value"), {{kBegin, 5}}, kBegin + 1);
  EXPECT_FALSE(store->write(batch));
  EXPECT_FALSE(store->find({OwnerId(6541), "other.value"}));
  ASSERT_TRUE(store->database().run("ALTER TABLE hold RENAME TO journal", "test"));
  const auto again = store->write(batch);
  ASSERT_TRUE(again) << again.error().text;
  EXPECT_EQ(points_of(*store, "other.value"), (Points{{kBegin, 5}}));
  EXPECT_EQ(points_of(*store, kKey), (Points{{kBegin, 1}}));
}

TEST(Store, EndsATransactionForWhichThereIsNotEnoughMemory) {
  Folder folder;
  auto store = opened(folder / "h");
  const auto failing = store->transact([]() -> Result<void> { throw std::bad_alloc(); });
  ASSERT_FALSE(failing);
  EXPECT_EQ(failing.error().code, ErrorCode::kBusy);
  EXPECT_FALSE(store->database().in_transaction());
}

TEST(Store, TakesLittleSpaceForSlowSeries) {
  Folder folder;
  auto store = opened(folder / "h");
  const auto series = number_series(kKey);
  Points written;
  for (std::int64_t i = 0; i < 24 * 6 * 30; ++i) {
    written.push_back({kBegin + i * 10 * kMinute, 21.5});
    ASSERT_TRUE(store->write(batch_of(series, {written.back()}, kBegin + i * 10 * kMinute)));
  }
  ASSERT_TRUE(store->close_all());
  const auto blocks = store->database().number("SELECT count(*) FROM block", "test");
  ASSERT_TRUE(blocks);
  EXPECT_LE(*blocks, 35);  // about one a day
  EXPECT_EQ(points_of(*store, kKey), written);
}

TEST(Store, ClosesTheBlocksOfSilentSeriesByAge) {
  Folder folder;
  auto store = opened(folder / "h");
  ASSERT_TRUE(store->write(batch_of(number_series(kKey), {{kBegin, 1}}, kBegin)));
  Batch other{wall(kBegin + 3 * kHour), {{1, number_series("other.value")}}, {{1, {kBegin + 3 * kHour, 2}}}, {}};
  ASSERT_TRUE(store->write(other));
  EXPECT_EQ(*store->database().number("SELECT count(*) FROM block", "test"), 1);
  EXPECT_EQ(points_of(*store, kKey), (Points{{kBegin, 1}}));
}

TEST(Store, ShortensItsJournal) {
  Folder folder;
  auto store = opened(folder / "h");
  const auto series = number_series(kKey);
  for (std::int64_t i = 0; i < 5000; ++i)
    ASSERT_TRUE(store->write(
        batch_of(series, {{kBegin + i * kSecond, 1.0 * static_cast<double>(i % 7)}}, kBegin + i * kSecond)));
  EXPECT_LE(*store->database().number("SELECT count(*) FROM journal", "test"), 1024 + 60);
  store.reset();
  EXPECT_EQ(values_of(*opened(folder / "h"), kKey).size(), 5000U);
}

TEST(Store, SkipsRowsThatAreDamagedAndCountsThem) {
  Folder folder;
  auto store = opened(folder / "h");
  const auto series = number_series(kKey);
  Points points;
  for (std::int64_t i = 0; i < 3000; ++i) points.push_back({kBegin + i * kSecond, static_cast<double>(i)});
  ASSERT_TRUE(store->write(batch_of(series, points, kBegin + 3000 * kSecond)));
  ASSERT_TRUE(
      store->database().run("UPDATE block SET data=x'01020304' WHERE start=(SELECT min(start) FROM block);"
                            "INSERT INTO journal VALUES(1000,5,x'ff')",
                            "test"));
  store.reset();
  store = opened(folder / "h");
  EXPECT_EQ(store->damaged(), 1U);
  const auto left = values_of(*store, kKey);
  EXPECT_LT(left.size(), 3000U);
  EXPECT_GT(left.size(), 1900U);
  EXPECT_EQ(store->damaged(), 2U);
}

TEST(Store, OfAnotherProgramIsLeftAlone) {
  Folder folder;
  std::ofstream(folder / "h") << std::string(5000, 'x');
  EXPECT_EQ(Store::open(folder / "h", sqlite::FileUse::kOwn, true).error().code, ErrorCode::kRefused);
  EXPECT_FALSE(std::filesystem::exists(folder / "h-lock"));
  {
    auto foreign = sqlite::open_file("test", folder / "f", sqlite::FileUse::kOwn, true);
    ASSERT_TRUE(foreign);
    ASSERT_TRUE(foreign->database.run("CREATE TABLE t(a); PRAGMA application_id=7", "test"));
  }
  EXPECT_EQ(Store::open(folder / "f", sqlite::FileUse::kOwn, true).error().code, ErrorCode::kRefused);
}

TEST(Store, RefusesQuestionsBeyondItsLimits) {
  Folder folder;
  auto store = opened(folder / "h");
  const SeriesName name{OwnerId(1), "a.value"};
  const auto code = [&](Question question) { return answer(*store, question).error().code; };
  EXPECT_EQ(code({{}, wall(0), wall(1), 10}), ErrorCode::kInvalid);
  EXPECT_EQ(code({std::vector(kMaxAsked + 1, name), wall(0), wall(1), 10}), ErrorCode::kInvalid);
  EXPECT_EQ(code({{name}, wall(1), wall(1), 10}), ErrorCode::kInvalid);
  EXPECT_EQ(code({{name}, wall(0), wall(1), 0}), ErrorCode::kInvalid);
  EXPECT_EQ(code({{name}, wall(0), wall(1), kMaxBuckets + 1}), ErrorCode::kInvalid);
  EXPECT_EQ(code({{name}, wall(0), WallTime::max(), 10}), ErrorCode::kInvalid);
  const auto unknown = answer(*store, {{name}, wall(0), wall(1), 10});
  ASSERT_TRUE(unknown);
  EXPECT_TRUE(unknown->series.at(0).buckets.empty());
}

TEST(Store, AnswersAboutThousandsOfYears) {
  Folder folder;
  auto store = opened(folder / "h");
  constexpr std::int64_t kThousandYears = 365'250 * kDay;
  const auto all = answer(*store, {{{OwnerId(1), "a.value"}}, wall(-kThousandYears), wall(kThousandYears), 1});
  ASSERT_TRUE(all);
  EXPECT_GE(all->bucket, std::chrono::milliseconds(kThousandYears));
}

TEST(Store, GoesOnWhenTheDiskHasRoomAgain) {
  Folder folder;
  const auto child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    auto store = Store::open(folder / "h", sqlite::FileUse::kOwn, true);
    if (!store) ::_exit(1);
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    const auto before = limit.rlim_cur;
    limit.rlim_cur = 100'000;
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::int64_t written = 0;
    std::mt19937_64 random(4);
    Batch batch;
    while (true) {
      Points points;
      for (std::int64_t i = 0; i < 500; ++i)
        points.push_back({kBegin + written + i, std::bit_cast<double>(random() >> 2U)});
      batch = batch_of(number_series(kKey), points, kBegin + written);
      if (!(*store)->write(batch)) break;
      written += 500;
    }
    limit.rlim_cur = before;
    ::setrlimit(RLIMIT_FSIZE, &limit);
    if (!(*store)->write(batch)) ::_exit(2);
    written += 500;
    std::int64_t next = 0;
    const auto row = *(*store)->find({OwnerId(6541), kKey});
    const auto done =
        each_point(**store, row, 0, kFurthest, [&](const Point& point) { return point.time == kBegin + next++; });
    ::_exit(done && next == written ? 0 : 3);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

/// A process that writes one point a batch, and reports each batch that was written, until it is killed.
[[noreturn]] void write_until_killed(const std::string& path, int report) {
  auto store = Store::open(path, sqlite::FileUse::kOwn, true);
  if (!store) ::_exit(1);
  for (std::int64_t i = 0;; ++i) {
    Batch batch{wall(kBegin + i * kSecond), {{0, number_series(kKey)}, {1, number_series("other.value")}}, {}, {}};
    batch.points = {{0, {kBegin + i * kSecond, static_cast<double>(i)}}, {1, {kBegin + i * kSecond, 1.0}}};
    batch.texts = {};
    if (!(*store)->write(batch)) ::_exit(2);
    if (::write(report, &i, sizeof i) != sizeof i) ::_exit(3);
  }
}

TEST(Store, OfAProcessThatWasKilledHasEachBatchThatWasWritten) {
  std::mt19937 random(7);
  for (int round = 0; round < 12; ++round) {
    Folder folder;
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const auto child = ::fork();
    if (child == 0) write_until_killed(folder / "h", ends[1]);
    ::close(ends[1]);
    std::int64_t last = -1;
    for (auto left = 1 + random() % 3000; left > 0; --left) {
      if (::read(ends[0], &last, sizeof last) != sizeof last) break;
    }
    ::kill(child, SIGKILL);
    std::int64_t more = 0;
    while (::read(ends[0], &more, sizeof more) == sizeof more) last = more;
    ::close(ends[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    auto store = opened(folder / "h");
    ASSERT_TRUE(store);
    const auto values = values_of(*store, kKey);
    ASSERT_GE(static_cast<std::int64_t>(values.size()), last + 1);
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_EQ(values[i], (Point{kBegin + static_cast<std::int64_t>(i) * kSecond, static_cast<double>(i)}));
    EXPECT_EQ(values_of(*store, "other.value").size(), values.size());
  }
}

TEST(Store, RefusesATimeWhoseBucketsWouldBeOutOfRange) {
  Folder folder;
  const auto store = opened(folder / "h");
  const auto ask = [&](std::int64_t from, std::int64_t to) {
    return answer(*store, {{{OwnerId(6541), kKey}}, wall(from), wall(to), 1});
  };
  EXPECT_EQ(ask(-kFurthest / 2, kBegin).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(ask(kBegin, kFurthest / 2).error().code, ErrorCode::kInvalid);
  EXPECT_TRUE(ask(-kFurthest / 9, kFurthest / 9));
}

}  // namespace
}  // namespace rubicon::history
