#include "island/island_tuples.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tuples/memory/memory_ecology.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;
using base::LogLevel;
using nlohmann::json;

class CountingSink final : public base::LogSink {
 public:
  void write(LogLevel, std::string_view, std::string_view text) override {
    last = std::to_string(++count) + ": " + std::string(text);
  }
  int count = 0;
  std::string last;
};

/// An island that owns the tuple, and a viewer.
class LogOfAnIsland : public testing::Test {
 protected:
  static constexpr OwnerId kHome{6541};
  static constexpr const char* kKey = "proxy.log.lines";

  void watch(bool passive) {
    subscription = viewer.subscribe({kHome, kKey}, {.passive = passive}, [this](const tuples::Event& event) {
      ++events;
      shown = json::parse(event.tuple.value);
    });
  }
  std::string last() const { return shown.empty() ? std::string("(none)") : shown.back()["text"].get<std::string>(); }

  VirtualScheduler time;
  CountingSink behind;
  LogLines lines{behind, time};
  base::Log log{lines, "knx-hall"};
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<tuples::Link> home_link = ecology.join(kHome).value(),
                                viewer_link = ecology.join(OwnerId(70000)).value();
  TupleSpace home{kHome, time, *home_link}, viewer{OwnerId(70000), time, *viewer_link};
  LogTuples tuples{time, home, kKey, lines};
  tuples::Handle subscription;
  int events = 0;
  json shown = json::array();
};

TEST_F(LogOfAnIsland, ShowsSubjectLevelTimeAndNumber) {
  log.warning("line lost: no route");
  watch(true);
  time.run_for(2s);
  ASSERT_EQ(shown.size(), 1U);
  EXPECT_EQ(shown[0]["number"], 1);
  EXPECT_EQ(shown[0]["level"], "warning");
  EXPECT_EQ(shown[0]["subject"], "knx-hall");
  EXPECT_EQ(shown[0]["text"], "line lost: no route");
  EXPECT_GT(shown[0]["time"].get<double>(), 0);
  EXPECT_EQ(behind.last, "1: line lost: no route");
}

TEST_F(LogOfAnIsland, KeepsTheLastLinesAndTheirNumbers) {
  watch(true);
  for (int i = 0; i < 250; ++i) log.info(std::to_string(i));
  time.run_for(1s);
  ASSERT_EQ(shown.size(), LogLines::kKept);
  EXPECT_EQ(shown.front()["number"], 151);
  EXPECT_EQ(last(), "249");
  EXPECT_EQ(behind.count, 250);
}

TEST_F(LogOfAnIsland, IsPublishedFourTimesASecondAtMost) {
  watch(true);
  time.run_for(2s);
  events = 0;
  for (int i = 0; i < 1000; ++i) {
    log.info(std::to_string(i));
    time.run_for(10ms);
  }
  EXPECT_GE(events, 39);
  EXPECT_LE(events, 41);
  time.run_for(250ms);
  EXPECT_EQ(last(), "999");
}

TEST_F(LogOfAnIsland, CostsNothingWhileNoComponentSubscribes) {
  time.run_for(1s);
  const auto before = home.stats().sets;
  for (int i = 0; i < 1000; ++i) {
    log.info(std::to_string(i));
    time.run_for(10ms);
  }
  EXPECT_EQ(home.stats().sets, before);
  watch(true);
  time.run_for(1250ms);
  EXPECT_EQ(last(), "999");
  subscription.reset();
  time.run_for(1s);
  const auto after = home.stats().sets;
  log.info("unseen");
  time.run_for(10s);
  EXPECT_EQ(home.stats().sets, after);
}

TEST_F(LogOfAnIsland, AnActiveSubscriberGetsThePresentLinesAtOnce) {
  log.info("present");
  time.run_for(10s);
  watch(false);
  time.run_for(1ms);
  EXPECT_EQ(last(), "present");
}

TEST_F(LogOfAnIsland, LinesAreBoundedPrintableAndWithoutSecrets) {
  watch(true);
  base::Log(lines, std::string(1000, 's')).error(std::string(100'000, 'x'));
  log.info("two\nlines \x1b[31m of mqtt://anna:geheim@host, password=geheim \xff");
  time.run_for(1s);
  EXPECT_EQ(shown[0]["subject"].get<std::string>().size(), LogLines::kMaxSubject);
  EXPECT_EQ(shown[0]["text"].get<std::string>().size(), LogLines::kMaxTextCount);
  EXPECT_EQ(last(), "two lines  [31m of mqtt://anna:****@host, password=**** ?");
  EXPECT_NE(behind.last.find("geheim"), std::string::npos) << "the log itself is not changed";
}

TEST_F(LogOfAnIsland, ASecretAcrossTheCutIsMasked) {
  watch(true);
  log.info(std::string(LogLines::kMaxTextCount - 12, '.') + " password=geheim");
  time.run_for(1s);
  EXPECT_EQ(last().find("geheim"), std::string::npos);
  EXPECT_EQ(last().size(), LogLines::kMaxTextCount);
}

TEST_F(LogOfAnIsland, DebugLinesAreKeptOnlyWhereTheyAreWanted) {
  log.debug("detail");
  EXPECT_TRUE(lines.lines().empty());
  LogLines all(behind, time, LogLevel::kDebug);
  base::Log(all, "x").debug("detail");
  EXPECT_EQ(all.lines().size(), 1U);
}

TEST_F(LogOfAnIsland, TheLargestListFitsATuple) {
  watch(true);
  for (int i = 0; i < 100; ++i) log.error(std::string(LogLines::kMaxTextCount, '"'));
  time.run_for(1s);
  EXPECT_EQ(shown.size(), LogLines::kKept);
}

}  // namespace
}  // namespace rubicon::island
