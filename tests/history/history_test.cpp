#include "history/history.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "base/virtual_scheduler.h"
#include "history/history_support.h"
#include "support/collecting_log.h"
#include "transport/memory/memory_worker.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::history {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr OwnerId kIsland{6541}, kComponent{70'000};
const std::string kPoint = "proxy.wsn-1.7.sensor.light-1";

/// An island's tuple space, and a history in another component; time is virtual.
class HistoryTest : public testing::Test {
 protected:
  HistoryTest() {
    island_.set(kPoint + ".description", R"({"data_type":"real","unit":"lx"})").value();
    good();
  }
  void good() { island_.set(kPoint + ".status", R"({"quality":"good","since":1})").value(); }
  void set(const std::string& value) { island_.set(kPoint + ".value", value).value(); }

  void open(config::HistorySetup setup = {}) {
    setup.file = "h";
    auto worker = std::make_unique<transport::MemoryWorker>(scheduler_);
    worker_ = worker.get();
    history_ = std::make_unique<History>(std::move(setup),
                                         History::Context{scheduler_, std::move(worker), log_, folder_.path()});
    history_->follow(space_);
    scheduler_.run_ready();
  }
  /// One value a second.
  void run(int count, double begin = 0) {
    for (int i = 0; i < count; ++i) {
      set(std::to_string(begin + i));
      scheduler_.run_for(seconds(1));
    }
  }
  Question last_hours(int span) const {
    const auto now = scheduler_.wall_now();
    return {{{kIsland, kPoint + ".value"}}, now - hours(span), now + seconds(1), 5000};
  }
  Result<Answer> ask(Question question) {
    Result<Answer> got = fail(ErrorCode::kExpired, "no answer");
    const auto handle = history_->ask(std::move(question), [&](Result<Answer> answer) { got = std::move(answer); });
    scheduler_.run_ready();
    return got;
  }
  std::size_t count() {
    const auto got = ask(last_hours(24));
    EXPECT_TRUE(got) << got.error().text;
    std::size_t sum = 0;
    if (got) {
      for (const auto& bucket : got->series.at(0).buckets) sum += bucket.count;
    }
    return sum;
  }

  Folder folder_;
  VirtualScheduler scheduler_;
  support::CollectingLog log_;
  tuples::MemoryEcology ecology_{scheduler_};
  std::unique_ptr<tuples::Link> island_link_ = std::move(*ecology_.join(kIsland));
  TupleSpace island_{kIsland, scheduler_, *island_link_};
  std::unique_ptr<tuples::Link> link_ = std::move(*ecology_.join(kComponent));
  TupleSpace space_{kComponent, scheduler_, *link_};
  transport::MemoryWorker* worker_ = nullptr;
  std::unique_ptr<History> history_;
};

TEST_F(HistoryTest, AnswersWhatThePointsWere) {
  open();
  run(100);
  const auto got = ask(last_hours(1));
  ASSERT_TRUE(got) << got.error().text;
  const auto& series = got->series.at(0);
  EXPECT_EQ(series.unit, "lx");
  EXPECT_EQ(series.buckets.size(), 100U);
  EXPECT_EQ(series.buckets.back().last, 99);
  EXPECT_EQ(history_->state(), "recording");
  EXPECT_GE(history_->counters().points, 99U);
  EXPECT_TRUE(history_->counters().recording);
}

TEST_F(HistoryTest, CreatesNoDemand) {
  island_.declare(kPoint + ".value").value();
  std::vector<bool> wanted;
  const auto watch =
      island_.watch_demand({kIsland, "**"}, [&](const tuples::Demand& demand) { wanted.push_back(demand.wanted); });
  open();
  run(5);
  EXPECT_TRUE(wanted.empty());
}

TEST_F(HistoryTest, KeepsOnePointOfASeriesInItsMinimum) {
  config::HistorySetup setup;
  setup.minimum = seconds(10);
  open(setup);
  run(100);
  EXPECT_NEAR(static_cast<double>(count()), 10, 1);
}

TEST_F(HistoryTest, ShowsAGapFromALostIslandUntilItReturns) {
  open();
  run(60);
  ecology_.cut(kIsland, kComponent);
  scheduler_.run_for(minutes(5));
  ecology_.mend(kIsland, kComponent);
  scheduler_.run_for(seconds(1));
  run(10, 100);
  const auto got =
      ask({{{kIsland, kPoint + ".value"}}, scheduler_.wall_now() - minutes(10), scheduler_.wall_now(), 5000});
  ASSERT_TRUE(got);
  const auto& gaps = got->series.at(0).gaps;
  ASSERT_EQ(gaps.size(), 2U);  // and that before the first value
  EXPECT_GE(gaps[1].to - gaps[1].from, minutes(4));
}

TEST_F(HistoryTest, GoesOnAfterARestart) {
  open();
  run(60);
  history_.reset();
  scheduler_.run_for(minutes(2));
  open();
  scheduler_.run_for(seconds(5));
  run(60, 1000);
  EXPECT_EQ(count(), 121U);  // and the value that the island had when the history came back
  EXPECT_FALSE(log_.contains("damaged"));
}

TEST_F(HistoryTest, KeepsPointsWhileTheDiskDoesNotAnswer) {
  open();
  run(10);
  worker_->hold();
  run(600, 100);
  EXPECT_LE(worker_->waiting(), 1U);
  worker_->release();
  scheduler_.run_for(seconds(3));
  EXPECT_GE(count(), 609U);
  EXPECT_EQ(history_->counters().dropped, 0U);
}

TEST_F(HistoryTest, TriesAgainWhenItCannotOpenTheFile) {
  std::filesystem::create_directory(folder_ / "h");
  open();
  EXPECT_THAT(history_->state(), HasSubstr("not written: "));
  EXPECT_FALSE(history_->counters().recording);
  EXPECT_FALSE(ask(last_hours(1)));
  run(10);
  std::filesystem::remove(folder_ / "h");
  scheduler_.run_for(minutes(1));
  EXPECT_EQ(history_->state(), "recording");
  run(10, 50);
  EXPECT_GE(count(), 10U);
}

TEST_F(HistoryTest, SetsADamagedFileAside) {
  open();
  run(10);
  history_.reset();
  std::fstream file(folder_ / "h", std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(100);
  file << std::string(3000, '\x5a');
  file.close();
  open();
  scheduler_.run_for(seconds(5));
  run(10, 50);
  EXPECT_EQ(count(), 11U);
  EXPECT_TRUE(log_.contains("a new one begins"));
  std::size_t aside = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    aside += entry.path().filename().string().starts_with("h.damaged-") ? 1U : 0U;
  EXPECT_GE(aside, 1U);
}

TEST_F(HistoryTest, GoesOnWhenTheClockJumpsAYear) {
  open();
  run(30);
  const auto now = scheduler_.wall_now();
  scheduler_.set_wall(now + hours(365 * 24));
  run(30, 100);
  scheduler_.set_wall(now + seconds(30));
  run(30, 200);
  EXPECT_EQ(count(), 60U);
  scheduler_.set_wall(now - hours(365 * 24));
  run(30, 300);
  EXPECT_EQ(count(), 30U);
  scheduler_.set_wall(now + hours(365 * 24) + minutes(2));
  EXPECT_EQ(count(), 30U);
}

TEST_F(HistoryTest, CancelsACallWithItsHandle) {
  open();
  run(5);
  bool called = false;
  {
    const auto handle = history_->ask(last_hours(1), [&](const Result<Answer>&) { called = true; });
  }
  auto pending = history_->ask(last_hours(1), [&](const Result<Answer>&) { called = true; });
  history_.reset();
  scheduler_.run_ready();
  EXPECT_FALSE(called);
}

TEST_F(HistoryTest, RefusesTooManyQuestions) {
  open();
  std::vector<Handle> handles;
  std::size_t busy = 0, good = 0;
  for (int i = 0; i < 40; ++i) {
    handles.push_back(history_->ask(last_hours(1), [&](const Result<Answer>& got) {
      if (got) ++good;
      if (!got && got.error().code == ErrorCode::kBusy) ++busy;
    }));
  }
  scheduler_.run_ready();
  EXPECT_EQ(good, 32U);
  EXPECT_EQ(busy, 8U);
}

TEST_F(HistoryTest, WritesBeforeTheQuestionsThatWait) {
  open();
  run(5);
  worker_->hold();
  std::vector<Handle> handles;
  std::size_t answered = 0;
  for (int i = 0; i < 20; ++i)
    handles.push_back(history_->ask(last_hours(1), [&](const Result<Answer>&) { ++answered; }));
  run(2, 100);
  EXPECT_EQ(worker_->waiting(), 2U);  // one question, then the batch
  worker_->release();
  scheduler_.run_for(seconds(1));
  EXPECT_EQ(answered, 20U);
}

TEST_F(HistoryTest, ListsItsSeries) {
  open();
  run(5);
  Result<std::vector<SeriesEntry>> got = fail(ErrorCode::kExpired, "no answer");
  const auto handle = history_->series(*Pattern::parse("6541:proxy.wsn-1.**"),
                                       [&](Result<std::vector<SeriesEntry>> series) { got = std::move(series); });
  scheduler_.run_ready();
  ASSERT_TRUE(got);
  ASSERT_EQ(got->size(), 1U);
  EXPECT_EQ(got->at(0).name.key, kPoint + ".value");
  EXPECT_EQ(got->at(0).unit, "lx");
  EXPECT_GE(got->at(0).last - got->at(0).first, seconds(3));
}

}  // namespace
}  // namespace rubicon::history
