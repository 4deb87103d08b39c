#include "history/history.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>

#include "base/virtual_scheduler.h"
#include "history/history_support.h"
#include "support/collecting_log.h"
#include "support/memory/memory_worker.h"
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

  void open(config::HistorySetup setup = {}, std::string directory = {}) {
    setup.file = "h";
    if (directory.empty()) directory = folder_.path();
    auto worker = std::make_unique<transport::MemoryWorker>(scheduler_);
    worker_ = worker.get();
    history_ = std::make_unique<History>(
        std::move(setup), History::Context{scheduler_, std::move(worker), log_, std::move(directory), clock_});
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
    Result<Answer> got = fail(ErrorCode::kBusy, "no answer");
    Answer answer;
    const auto keep = [&](const Answer& found) {
      answer = found;
      return std::string();
    };
    const auto handle = history_->ask("test", std::move(question), keep, [&](const Result<std::string>& text) {
      got = text ? Result<Answer>(answer) : fail(text.error());
    });
    scheduler_.run_ready();
    return got;
  }
  /// A question whose words do not matter.
  Handle ask(const std::string& caller, History::TextCall call) {
    return history_->ask(
        caller, last_hours(1), [](const Answer&) { return "text"; }, std::move(call));
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
  Questions::Clock clock_{};
};

/// A history of notes, of which there are enough that a question for all of them takes some thousand steps.
class Notes : public HistoryTest {
 protected:
  Notes() {
    clock_ = [this] {
      ++clock_reads_;
      if (on_clock_) on_clock_();
      return SteadyTime(clock_step_ * clock_reads_);
    };
    config::HistorySetup setup;
    setup.patterns = {{kIsland, "robot.note"}};
    open(setup);
    for (int i = 0; i < 2000; ++i) {
      island_.set("robot.note", "note " + std::to_string(i)).value();
      scheduler_.run_for(seconds(1));
    }
  }
  Question all_notes() {
    const auto now = scheduler_.wall_now();
    return {{{kIsland, "robot.note"}}, now - hours(1), now + seconds(1), 5000};
  }

  int clock_reads_ = 0;
  Duration clock_step_{0};
  std::function<void()> on_clock_;
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
  EXPECT_EQ(history_->state().word, "recording");
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
  EXPECT_EQ(history_->state().word, "failing");
  EXPECT_THAT(history_->state().reason, HasSubstr("not a regular file"));
  EXPECT_FALSE(history_->counters().recording);
  EXPECT_FALSE(ask(last_hours(1)));
  run(10);
  std::filesystem::remove(folder_ / "h");
  scheduler_.run_for(minutes(1));
  EXPECT_EQ(history_->state().word, "recording");
  run(10, 50);
  EXPECT_GE(count(), 10U);
}

TEST_F(HistoryTest, LogsThePointsThatItCouldNotWriteAtTheEnd) {
  open();
  run(10);
  history_.reset();
  EXPECT_FALSE(log_.contains("are lost"));
  open();
  run(10);
  sqlite3* other = nullptr;
  ASSERT_EQ(::sqlite3_open((folder_ / "h").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(::sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  set("17");
  scheduler_.run_ready();
  history_.reset();
  ::sqlite3_close(other);
  EXPECT_TRUE(log_.contains("1 points are lost: history " + folder_ / "h"));
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
  const auto call = [&](const Result<std::string>&) { called = true; };
  { const auto handle = ask("a", call); }
  auto pending = ask("a", call);
  history_.reset();
  scheduler_.run_ready();
  EXPECT_FALSE(called);
}

TEST_F(HistoryTest, RefusesTooManyQuestionsOfACallerAndTakesThoseOfOthers) {
  open();
  std::vector<Handle> handles;
  std::size_t busy = 0, good = 0;
  const auto call = [&](const Result<std::string>& got) {
    if (got) ++good;
    if (!got && got.error().code == ErrorCode::kBusy) ++busy;
  };
  for (int i = 0; i < 40; ++i) handles.push_back(ask("a", call));
  for (int i = 0; i < 40; ++i) handles.push_back(ask("caller " + std::to_string(i), call));
  scheduler_.run_ready();
  EXPECT_EQ(good, 1U + 8U + 24U);  // the first one did not wait
  EXPECT_EQ(busy, 31U + 16U);
}

TEST_F(HistoryTest, GivesCallersTheirTurns) {
  open();
  worker_->hold();
  std::string order;
  std::vector<Handle> handles;
  for (const auto* caller : {"a", "a", "a", "a", "b", "c", "b"})
    handles.push_back(ask(caller, [&order, caller](const Result<std::string>&) { order += caller; }));
  worker_->release();
  scheduler_.run_ready();
  EXPECT_EQ(order, "aabcaba");
}

TEST_F(HistoryTest, AQuestionThatWasCancelledTakesNoPlace) {
  open();
  worker_->hold();
  std::size_t good = 0;
  const auto call = [&](const Result<std::string>& got) { good += got ? 1U : 0U; };
  const auto first = ask("a", call);
  for (int i = 0; i < 20; ++i) std::ignore = ask("a", call);
  const auto last = ask("a", call);
  worker_->release();
  scheduler_.run_ready();
  EXPECT_EQ(good, 2U);
}

TEST_F(HistoryTest, WritesBeforeTheQuestionsThatWait) {
  open();
  run(5);
  worker_->hold();
  std::vector<Handle> handles;
  std::size_t answered = 0;
  for (int i = 0; i < 20; ++i)
    handles.push_back(ask("caller " + std::to_string(i), [&](const Result<std::string>&) { ++answered; }));
  run(2, 100);
  EXPECT_EQ(worker_->waiting(), 2U);  // one question, then the batch
  worker_->release();
  scheduler_.run_for(seconds(1));
  EXPECT_EQ(answered, 20U);
}

TEST_F(HistoryTest, GoesOnWithoutMemoryForAnAnswer) {
  open();
  run(5);
  Result<std::string> got;
  const auto handle = history_->ask(
      "a", last_hours(1), [](const Answer&) -> std::string { throw std::bad_alloc(); },
      [&](Result<std::string> text) { got = std::move(text); });
  scheduler_.run_ready();
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, ErrorCode::kBusy);
  EXPECT_EQ(count(), 5U);
}

TEST_F(Notes, EndTheirQuestionsAfterTwoSeconds) {
  clock_step_ = seconds(1);
  const auto late = ask(all_notes());
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kExpired);
  EXPECT_THAT(late.error().text, HasSubstr("longer than 2 s; ask for a shorter time"));
  EXPECT_EQ(clock_reads_, 3);
  clock_step_ = Duration(0);
  const auto good = ask(all_notes());
  ASSERT_TRUE(good);
  EXPECT_GE(good->series.at(0).texts.size(), 1990U);
  EXPECT_GT(clock_reads_, 10);
}

TEST_F(Notes, EndAQuestionInItsMiddleWhenItIsCancelled) {
  bool called = false;
  Handle handle = history_->ask(
      "a", all_notes(), [](const Answer&) { return std::string(); },
      [&](const Result<std::string>&) { called = true; });
  on_clock_ = [&] {
    if (clock_reads_ == 3) handle = {};
  };
  scheduler_.run_ready();
  EXPECT_EQ(clock_reads_, 3);
  EXPECT_FALSE(called);
}

TEST_F(Notes, WaitForNoQuestionWhenTheyEnd) {
  worker_->hold();
  const auto handle = history_->ask(
      "a", all_notes(), [](const Answer&) { return std::string(); }, [](const Result<std::string>&) {});
  island_.set("robot.note", "the last one").value();
  scheduler_.run_ready();
  history_.reset();
  EXPECT_LE(clock_reads_, 2);
  const auto store = opened(folder_ / "h", sqlite::FileUse::kRead);
  std::string last;
  ASSERT_TRUE(each_text(*store, 1, -kFurthest, kFurthest, [&](const TextValue& text) {
    if (!text.text.empty()) last = text.text;
    return true;
  }));
  EXPECT_EQ(last, "the last one");
}

TEST_F(HistoryTest, ShowsItsStatusAsATuple) {
  std::filesystem::create_directory(folder_ / "h");
  open();
  nlohmann::json last;
  const auto watch = space_.subscribe({kComponent, "web.history.status"}, {}, [&](const tuples::Event& event) {
    const bool is_set = event.kind == tuples::EventKind::kSet;
    last = is_set ? nlohmann::json::parse(event.tuple.value) : nlohmann::json();
  });
  const auto shown = [&] {
    scheduler_.run_ready();
    return last;
  };
  std::optional<StatusTuple> status(std::in_place, scheduler_, space_, "web.history.status", *history_);
  scheduler_.run_for(seconds(2));
  EXPECT_EQ(shown()["state"], "failing");
  EXPECT_THAT(shown()["reason"].get<std::string>(), HasSubstr("not a regular file"));
  EXPECT_EQ(shown()["file"], folder_ / "h");
  std::filesystem::remove(folder_ / "h");
  scheduler_.run_for(minutes(2));
  run(30);
  EXPECT_EQ(shown()["state"], "recording");
  EXPECT_EQ(shown()["reason"], "");
  EXPECT_GE(shown()["points"].get<int>(), 19);
  EXPECT_GT(shown()["bytes"].get<int>(), 0);
  EXPECT_EQ(shown()["dropped"], 0);
  status.reset();
  EXPECT_EQ(shown(), nlohmann::json());
}

/// Those who read the tuple are in other folders than this process.
TEST_F(HistoryTest, TheStatusNamesTheFileFromTheRoot) {
  open({}, "./" + std::filesystem::relative(folder_.path()).string());
  const StatusTuple status(scheduler_, space_, "web.history.status", *history_);
  const auto shown = space_.get(kComponent, "web.history.status");
  ASSERT_TRUE(shown);
  EXPECT_EQ(nlohmann::json::parse(shown->value)["file"], (std::filesystem::canonical(folder_.path()) / "h").string());
}

TEST_F(HistoryTest, ListsAPartOfItsSeriesInNaturalOrder) {
  config::HistorySetup setup;
  setup.patterns = {{kIsland, "robot.*"}};
  open(setup);
  for (const auto* key : {"robot.s10", "robot.s2", "robot.s1", "robot.s3"}) island_.set(key, "1").value();
  scheduler_.run_for(seconds(2));
  std::string names;
  const auto handle = history_->series(
      "a", {kIsland, "**"}, {"6541:robot.s1", 2},
      [](const std::vector<SeriesEntry>& found) {
        std::string all;
        for (const auto& one : found) all += one.name.key + " ";
        return all;
      },
      [&](const Result<std::string>& text) { names = text.value_or("none"); });
  scheduler_.run_ready();
  EXPECT_EQ(names, "robot.s2 robot.s3 ");
}

TEST_F(HistoryTest, ListsItsSeries) {
  open();
  run(5);
  std::vector<SeriesEntry> got;
  const auto handle = history_->series(
      "a", *Pattern::parse("6541:proxy.wsn-1.**"), {},
      [&](const std::vector<SeriesEntry>& found) {
        got = found;
        return std::string();
      },
      [](const Result<std::string>&) {});
  scheduler_.run_ready();
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got.at(0).name.key, kPoint + ".value");
  EXPECT_EQ(got.at(0).unit, "lx");
  EXPECT_GE(got.at(0).last - got.at(0).first, seconds(3));
}

}  // namespace
}  // namespace rubicon::history
