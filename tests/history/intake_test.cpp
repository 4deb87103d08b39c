#include "history/intake.h"

#include <gtest/gtest.h>

#include "history/history_support.h"

namespace rubicon::history {
namespace {

constexpr OwnerId kSource{6541};
const std::string kLight = "proxy.wsn-1.7.sensor.light-1";

/// An intake with a clock that the test sets.
class IntakeTest : public testing::Test {
 protected:
  static WallTime at(double seconds) { return wall(kBegin + static_cast<std::int64_t>(seconds * 1000)); }

  void set(double seconds, const std::string& key, const std::string& text) {
    TupleView tuple;
    tuple.owner = kSource;
    tuple.key = key;
    tuple.value = text;
    tuple.write_time = at(seconds);
    intake_.changed(tuple, Instant::recorded(at(seconds)));
  }
  void value(double seconds, const std::string& text) { set(seconds, kLight + ".value", text); }
  void quality(double seconds, const std::string& word) {
    set(seconds, kLight + ".status", "{\"quality\":\"" + word + "\",\"since\":1}");
  }
  void describe(double seconds, const std::string& json) { set(seconds, kLight + ".description", json); }
  /// A point that is good from the beginning.
  void good_number() {
    describe(0, R"({"data_type":"real","unit":"lx"})");
    quality(0, "good");
  }
  /// All points that came, in seconds since the beginning.
  std::vector<std::pair<double, double>> points() {
    const auto batch = intake_.take(at(0));
    std::vector<std::pair<double, double>> list;
    for (const auto& one : batch.points)
      list.emplace_back(static_cast<double>(one.point.time - kBegin) / 1000, one.point.gap() ? -99 : one.point.value);
    for (const auto& [slot, declaration] : batch.declared) declared_ = declaration;
    for (const auto& text : batch.texts) texts_.push_back(text.text);
    return list;
  }
  using List = std::vector<std::pair<double, double>>;

  Intake intake_{{Pattern{std::nullopt, "proxy.*.*.sensor.motion-1.value"}}};
  Declaration declared_;
  std::vector<std::string> texts_;
};

TEST_F(IntakeTest, MakesPointsOfNumbers) {
  good_number();
  value(1, "686.6");
  value(2, "690");
  EXPECT_EQ(points(), (List{{1, 686.6}, {2, 690}}));
  EXPECT_EQ(declared_.name.key, kLight + ".value");
  EXPECT_EQ(declared_.unit, "lx");
  EXPECT_EQ(declared_.kind, SeriesKind::kNumber);
}

TEST_F(IntakeTest, MarksAGapWhereTheQualityIsNoLongerGood) {
  good_number();
  value(1, "5");
  quality(60, "stale");
  value(70, "");
  quality(90, "device-offline");
  quality(100, "good");
  value(100, "6");
  EXPECT_EQ(points(), (List{{1, 5}, {60, -99}, {100, 5}, {100, 6}}));
}

TEST_F(IntakeTest, KeepsTheValueThatEndsAGapAlsoIfItsStatusComesLater) {
  good_number();
  value(1, "5");
  quality(60, "stale");
  value(100, "6");
  quality(100, "good");
  EXPECT_EQ(points(), (List{{1, 5}, {60, -99}, {100, 6}}));
}

TEST_F(IntakeTest, DoesNotStoreValuesThatWereOnlyRemembered) {
  describe(0, R"({"data_type":"real"})");
  quality(0, "stored");
  value(0, "5");
  EXPECT_EQ(points(), List{});
  quality(10, "good");
  value(10, "7");
  EXPECT_EQ(points(), (List{{0, 5}, {10, 7}}));
}

TEST_F(IntakeTest, TakesAssumedValues) {
  describe(0, R"({"data_type":"real"})");
  quality(0, "assumed");
  value(1, "5");
  EXPECT_EQ(points(), (List{{1, 5}}));
}

TEST_F(IntakeTest, WaitsForStatusAndDescriptionButNotForLong) {
  value(0, "5");
  EXPECT_EQ(points(), List{});
  quality(1, "good");
  EXPECT_EQ(points(), List{});
  describe(1, R"({"data_type":"real"})");
  EXPECT_EQ(points(), (List{{0, 5}}));
  set(2, "proxy.a.b.sensor.c-1.value", "7");
  intake_.tick(Instant::recorded(at(4)));
  EXPECT_EQ(points(), List{});
  intake_.tick(Instant::recorded(at(8)));
  EXPECT_EQ(points(), (List{{2, 7}}));
}

TEST_F(IntakeTest, StoresEqualValuesOnceInTenMinutes) {
  good_number();
  for (int i = 0; i < 1300; ++i) value(i, "5");
  EXPECT_EQ(points(), (List{{0, 5}, {600, 5}, {1200, 5}}));
}

TEST_F(IntakeTest, StoresEachEventOnceAndNoneThatIsOver) {
  describe(0, R"({"data_type":"enumeration","report":"event","words":["toggle","hold"]})");
  quality(0, "good");
  value(1, "toggle");
  value(2, "toggle");
  value(2, "toggle");  // by another pattern
  value(4, "");
  for (int i = 10; i <= 1300; i += 10) intake_.tick(Instant::recorded(at(i)));
  EXPECT_EQ(points(), (List{{1, 0}, {2, 0}}));
  quality(1301, "stale");
  quality(1302, "good");
  value(1303, "toggle");
  EXPECT_EQ(points(), (List{{1301, -99}, {1303, 0}}));
}

TEST_F(IntakeTest, StoresEqualTextsOfEvents) {
  describe(0, R"({"data_type":"text","report":"event"})");
  quality(0, "good");
  value(1, "badge 7");
  value(2, "badge 7");
  EXPECT_EQ(points(), List());
  EXPECT_EQ(texts_, (std::vector<std::string>{"badge 7", "badge 7"}));
}

TEST_F(IntakeTest, StoresTheEndOfASteadyTime) {
  good_number();
  for (int i = 0; i <= 100; ++i) value(i, "5");
  value(101, "9");
  value(102, "9");
  value(103, "8");
  EXPECT_EQ(points(), (List{{0, 5}, {100, 5}, {101, 9}, {103, 8}}));
}

TEST_F(IntakeTest, RepeatsASteadyValueWithoutEvents) {
  good_number();
  value(0, "5");
  for (int i = 10; i <= 1300; i += 10) intake_.tick(Instant::recorded(at(i)));
  EXPECT_EQ(points(), (List{{0, 5}, {600, 5}, {1200, 5}}));
  quality(1310, "stale");
  for (int i = 1320; i <= 3000; i += 10) intake_.tick(Instant::recorded(at(i)));
  EXPECT_EQ(points(), (List{{1310, -99}}));
}

TEST_F(IntakeTest, GoesOnWhenTheClockJumps) {
  good_number();
  constexpr double kYear = 365 * 86'400;
  value(kYear, "1");
  value(1, "2");  // back
  intake_.tick(Instant::recorded(at(2)));
  value(3, "2");
  value(kYear + 4, "2");  // and forth
  EXPECT_EQ(points(), (List{{kYear, 1}, {1, 2}, {kYear + 4, 2}}));
  quality(5, "bad");
  EXPECT_EQ(points(), (List{{5, -99}}));
}

TEST_F(IntakeTest, NumbersTheWordsOfStates) {
  describe(0, R"({"data_type":"boolean","words":["closed","open"]})");
  quality(0, "good");
  value(1, "open");
  value(2, "closed");
  value(3, "ajar");
  EXPECT_EQ(points(), (List{{1, 1}, {2, 0}, {3, 2}}));
  EXPECT_EQ(declared_.kind, SeriesKind::kWords);
  EXPECT_EQ(declared_.words, (std::vector<std::string>{"closed", "open", "ajar"}));
}

TEST_F(IntakeTest, KnowsTheUsualWordsOfTuplesWithoutDescription) {
  set(0, "robot.gripper", "on");
  set(1, "robot.gripper", "off");
  EXPECT_EQ(points(), (List{{0, 1}, {1, 0}}));
  EXPECT_EQ(declared_.words, (std::vector<std::string>{"off", "on"}));
}

TEST_F(IntakeTest, KeepsTextsThatChange) {
  set(0, "robot.pose", R"({"x":1})");
  set(1, "robot.pose", R"({"x":1})");
  set(2, "robot.pose", R"({"x":2})");
  set(3, "robot.pose", std::string(5000, 'x'));
  intake_.gone(kSource, "robot.pose", Instant::recorded(at(4)));
  EXPECT_EQ(points(), List{});
  EXPECT_EQ(texts_, (std::vector<std::string>{R"({"x":1})", R"({"x":2})", ""}));
  EXPECT_EQ(declared_.kind, SeriesKind::kText);
  EXPECT_EQ(intake_.unfit(), 1U);
}

TEST_F(IntakeTest, CountsWordsAmongNumbers) {
  good_number();
  for (const auto* text : {"5", "warm", "inf", "nan", "6"}) value(1, text);
  EXPECT_EQ(points(), (List{{1, 5}, {1, 6}}));
  EXPECT_EQ(intake_.unfit(), 3U);
}

TEST_F(IntakeTest, MarksAGapWhenTheOwnerIsLost) {
  good_number();
  value(1, "5");
  intake_.gone(kSource, kLight + ".value", Instant::recorded(at(50)));
  EXPECT_EQ(points(), (List{{1, 5}, {50, -99}}));
}

TEST_F(IntakeTest, IgnoresCommandsAndWhatIsExcluded) {
  set(0, "proxy.wsn-1.7.actuator.lamp-1.command", "on");
  set(0, "proxy.wsn-1.7.sensor.motion-1.value", "on");
  set(0, "proxy.wsn-1.7.sensor.motion-1.status", R"({"quality":"good"})");
  intake_.tick(Instant::recorded(at(60)));
  EXPECT_EQ(points(), List{});
}

TEST_F(IntakeTest, DropsBeyondItsLimitAndCounts) {
  good_number();
  intake_.limit(2 * kPointBytes);
  for (int i = 0; i < 5; ++i) value(i, std::to_string(i));
  EXPECT_EQ(points().size(), 2U);
  EXPECT_EQ(intake_.dropped(), 3U);
  value(10, "10");
  EXPECT_EQ(points(), (List{{1.001, -99}, {10, 10}}));  // no line goes across what is missing
}

TEST_F(IntakeTest, CountsTheBytesOfTexts) {
  intake_.limit(10'000);
  for (int i = 0; i < 10; ++i) set(i, "robot.pose", std::string(4000, static_cast<char>('a' + i)));
  EXPECT_LE(intake_.bytes(), 10'000U);
  EXPECT_EQ(intake_.dropped(), 8U);
  set(20, "robot.pose", "z");
  const auto texts = intake_.take(at(10)).texts;
  ASSERT_EQ(texts.size(), 4U);
  EXPECT_EQ(texts[2].text, "");  // the mark of a gap: eight are missing
  EXPECT_EQ(texts[3].text, "z");
}

TEST_F(IntakeTest, MarksAGapWithTheFirstRoomIfThereIsNoneWhenItBegins) {
  good_number();
  intake_.limit(kPointBytes);
  value(1, "5");
  quality(60, "device-offline");
  EXPECT_EQ(points(), (List{{1, 5}}));
  for (int i = 70; i <= 3000; i += 10) intake_.tick(Instant::recorded(at(i)));
  EXPECT_EQ(points(), (List{{60, -99}}));
  for (int i = 3010; i <= 9000; i += 10) intake_.tick(Instant::recorded(at(i)));
  EXPECT_EQ(points(), List{});
}

TEST_F(IntakeTest, WaitsAsLongWhateverTheClockDoes) {
  const auto begin = Instant::recorded(at(1'000'000));
  value(1'000'000, "5");
  const auto later = [&](double wall_seconds, int steady_seconds) {
    intake_.tick({at(wall_seconds), begin.steady + std::chrono::seconds(steady_seconds)});
    return points();
  };
  EXPECT_EQ(later(1, 1), List{});          // set back
  EXPECT_EQ(later(2'000'000, 4), List{});  // set forward
  EXPECT_EQ(later(2, 6), (List{{1'000'000, 5}}));
}

TEST_F(IntakeTest, NamesEachSeriesWithAValueThatDoesNotFitOnce) {
  good_number();
  for (const auto* text : {"5", "12a", "12b"}) value(1, text);
  const auto named = intake_.take_unfit();
  ASSERT_EQ(named.size(), 1U);
  EXPECT_EQ(named[0].name.key, kLight + ".value");
  value(2, "12c");
  EXPECT_TRUE(intake_.take_unfit().empty());
}

TEST_F(IntakeTest, TakesABoundedNumberOfSeries) {
  for (std::size_t i = 0; i < Intake::kMaxSeries + 3; ++i) set(0, "robot.s" + std::to_string(i), "1");
  EXPECT_EQ(intake_.refused(), 3U);
  set(1, "robot.s1", "2");  // one of those that are there
  const auto batch = intake_.take(at(1));
  EXPECT_EQ(batch.points.size(), Intake::kMaxSeries + 1);
}

TEST_F(IntakeTest, AfterARestartAValueOfARecordingKeepsItsTimeAndAPresentOneIsInForceSinceNow) {
  const auto first_after = [this](double measured, double now) {
    Intake intake{{}};
    intake.seed({{{kSource, kLight + ".value"}, SeriesKind::kNumber, "lx", {}}});
    const auto change = [&](const std::string& key, const std::string& text, double time) {
      TupleView tuple;
      tuple.owner = kSource;
      tuple.key = key;
      tuple.value = text;
      tuple.write_time = at(time);
      intake.changed(tuple, Instant::recorded(at(now)));
    };
    change(kLight + ".description", R"({"data_type":"real","unit":"lx"})", now);
    change(kLight + ".status", R"({"quality":"good","since":1})", now);
    change(kLight + ".value", "5", measured);
    const auto batch = intake.take(at(now));
    return batch.points.empty() ? -1 : static_cast<double>(batch.points[0].point.time - kBegin) / 1000;
  };
  EXPECT_EQ(first_after(1000, 1600), 1600) << "of ten minutes ago, and still true";
  EXPECT_EQ(first_after(1000, 1001), 1000) << "it came just now";
  EXPECT_EQ(first_after(1000, 100'000), 1000) << "of a recording";
}

TEST_F(IntakeTest, AfterARestartAnEventKeepsItsTime) {
  intake_.seed({{{kSource, kLight + ".value"}, SeriesKind::kWords, "", {"toggle"}}});
  describe(1600, R"({"data_type":"enumeration","report":"event","words":["toggle"]})");
  quality(1600, "good");
  TupleView tuple;
  tuple.owner = kSource;
  const auto key = kLight + ".value";
  tuple.key = key;
  tuple.value = "toggle";
  tuple.write_time = at(1000);
  intake_.changed(tuple, Instant::recorded(at(1600)));
  EXPECT_EQ(points(), (List{{1000, 0}}));
}

TEST_F(IntakeTest, KeepsTheKindThatTheFileHas) {
  intake_.seed({{{kSource, kLight + ".value"}, SeriesKind::kWords, "", {"a", "b"}}});
  good_number();
  value(1, "b");
  value(2, "7");
  EXPECT_EQ(points(), (List{{1, 1}, {2, 2}}));
  EXPECT_EQ(declared_.words, (std::vector<std::string>{"a", "b", "7"}));
}

}  // namespace
}  // namespace rubicon::history
