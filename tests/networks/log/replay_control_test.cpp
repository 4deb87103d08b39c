#include <gmock/gmock.h>

#include "base/clocks.h"
#include "networks/log/log_recordings.h"
#include "networks/log/log_support.h"
#include "networks/log/replay_clock.h"

namespace rubicon::networks::log {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Two tables with the values 1 to 10 and 11 to 20, one each second: value v at position v - 1.
class ReplayControl : public testing::Test {
 protected:
  using Options = std::vector<std::pair<std::string, ConfigNode>>;

  void start(Options more = {}) {
    Options all{{"format", scalar("csv")},
                {"files", list({"a.csv", "b.csv"})},
                {"period", scalar("1s")},
                {"map", map({{"room", map({{"columns", map({{"t", sensor("temperature-1")}})}})}})}};
    for (auto& [key, value] : more) {
      std::erase_if(all, [&key = key](const auto& entry) { return entry.first == key; });
      all.emplace_back(key, std::move(value));
    }
    listener_.files.files = {{"a.csv", table(1, 10)}, {"b.csv", table(11, 20)}};
    open(map(std::move(all)));
  }
  void open(ConfigNode options) {
    options_ = std::move(options);
    made_ = make_log(listener_, options_, types_);
    ASSERT_NE(made_.network, nullptr) << (made_.errors.empty() ? "" : made_.errors.front());
    ASSERT_TRUE(made_.network->open());
  }
  static std::string table(int first, int last) {
    std::string text = "t\n";
    for (int i = first; i <= last; ++i) text += std::to_string(i) + "\n";
    return text;
  }

  void run(Duration time) { listener_.time.run_for(time); }
  /// The reason of a refusal; empty = done.
  std::string set(std::string_view name, std::string_view text) {
    const auto done = made_.network->control(name, text);
    return done ? std::string() : done.error().text;
  }
  std::string go_to(std::string_view text) { return set("replay-position", text); }
  /// The values since the last call.
  std::vector<std::string> news() {
    std::vector<std::string> texts;
    const auto all = listener_.readings();
    for (; seen_ < all.size(); ++seen_) texts.push_back(model::to_text(all[seen_].value));
    return texts;
  }
  std::string shown(const std::string& name) {
    const auto texts = listener_.last_state().texts;
    const auto found = texts.find(name);
    return found == texts.end() ? "(none)" : found->second;
  }

  TypeCatalogue types_;
  Listener listener_;
  ConfigNode options_;
  Made made_;
  std::size_t seen_ = 0;
};

TEST_F(ReplayControl, HasThreePropertiesWithDescriptions) {
  start();
  std::vector<std::string> names;
  for (const auto& control : made_.network->controls()) {
    names.push_back(control.name);
    EXPECT_EQ(control.description.access, "read-write");
  }
  EXPECT_THAT(names, ElementsAre("replay-state", "replay-speed", "replay-position"));
  EXPECT_EQ(shown("replay-state"), "playing");
  EXPECT_EQ(shown("replay-speed"), "1");
}

TEST_F(ReplayControl, APauseHoldsTheMomentAndTheRest) {
  start();
  run(2500ms);
  EXPECT_THAT(news(), ElementsAre("1", "2", "3"));
  EXPECT_EQ(set("replay-state", "paused"), "");
  EXPECT_EQ(shown("replay-state"), "paused");
  EXPECT_EQ(shown("replay-position"), "2.500");
  const auto reports = listener_.of<model::State>().size();
  run(1h);
  EXPECT_THAT(news(), IsEmpty());
  EXPECT_EQ(listener_.of<model::State>().size(), reports) << "nothing moves";
  EXPECT_EQ(set("replay-state", "playing"), "");
  run(499ms);
  EXPECT_THAT(news(), IsEmpty());
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("4"));
  EXPECT_EQ(set("replay-state", "playing"), "") << "again";
  run(1s);
  EXPECT_THAT(news(), ElementsAre("5"));
}

TEST_F(ReplayControl, ANewSpeedHoldsFromNowOn) {
  start();
  run(2500ms);
  news();
  EXPECT_EQ(set("replay-speed", "10"), "");
  EXPECT_EQ(shown("replay-speed"), "10");
  run(50ms);
  EXPECT_THAT(news(), ElementsAre("4"));
  run(100ms);
  EXPECT_THAT(news(), ElementsAre("5"));
  EXPECT_EQ(set("replay-speed", "0.5"), "");
  run(1999ms);
  EXPECT_THAT(news(), IsEmpty());
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("6"));
  EXPECT_EQ(set("replay-speed", "max"), "");
  run(1ms);
  EXPECT_EQ(news().back(), "20");
  EXPECT_EQ(shown("replay-state"), "ended");
}

TEST_F(ReplayControl, ForwardIntoTheNextFileShowsTheLastValueBefore) {
  start();
  run(500ms);
  news();
  EXPECT_EQ(go_to("15.5"), "");
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("16"));
  EXPECT_EQ(shown("replay-position"), "15.500");
  run(498ms);
  EXPECT_THAT(news(), IsEmpty());
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("17"));
}

TEST_F(ReplayControl, BackIntoTheFileBeforeAndOnlyOnce) {
  start();
  run(12500ms);
  news();
  EXPECT_EQ(go_to("3.5"), "");
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("4"));
  run(6500ms);
  EXPECT_THAT(news(), ElementsAre("5", "6", "7", "8", "9", "10", "11"));
  EXPECT_THAT(listener_.failures, IsEmpty());
}

TEST_F(ReplayControl, WithinTheGapBetweenTwoStepsNothingIsRepeated) {
  start();
  run(2100ms);
  news();
  EXPECT_EQ(go_to("2.9"), "");
  run(99ms);
  EXPECT_THAT(news(), IsEmpty());
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("4"));
  EXPECT_EQ(go_to("4"), "") << "exactly at a step";
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("5"));
}

TEST_F(ReplayControl, SpansCountFromTheBeginningOrFromHere) {
  start();
  run(1500ms);
  news();
  EXPECT_EQ(go_to("+5s"), "");
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("7"));
  EXPECT_EQ(go_to("-2s"), "");
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("5"));
  EXPECT_EQ(go_to("10s"), "");
  run(1ms);
  EXPECT_EQ(news().back(), "11");
  EXPECT_EQ(go_to("-1h"), "") << "not before the beginning";
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("1"));
}

TEST_F(ReplayControl, WhilePausedItShowsTheMomentAndStays) {
  start();
  run(500ms);
  set("replay-state", "paused");
  news();
  EXPECT_EQ(go_to("7.25"), "");
  run(1min);
  EXPECT_THAT(news(), ElementsAre("8"));
  EXPECT_EQ(shown("replay-state"), "paused");
  EXPECT_EQ(shown("replay-position"), "7.250");
  EXPECT_EQ(go_to("2"), "");
  run(1min);
  EXPECT_THAT(news(), ElementsAre("2"));
  set("replay-state", "playing");
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("3"));
}

TEST_F(ReplayControl, InALoopEachRoundCanBeSearched) {
  start({{"loop", scalar("yes")}});
  run(25500ms);  // the second round
  news();
  EXPECT_EQ(shown("replay-end"), "19.000");
  EXPECT_EQ(go_to("18.5"), "");
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("19"));
  run(500ms);
  EXPECT_THAT(news(), ElementsAre("20", "1"));
  EXPECT_EQ(go_to("0"), "") << "here it is";
  run(300ms);
  EXPECT_THAT(news(), IsEmpty());
  EXPECT_EQ(go_to("0"), "");
  run(2500ms);
  EXPECT_THAT(news(), ElementsAre("1", "2", "3"));
  EXPECT_THAT(go_to("19.001"), HasSubstr("19.001 is after the end of the recording, 19.000"));
}

TEST_F(ReplayControl, BehindAnUnknownEndItEndsWithTheLastValues) {
  start();
  run(500ms);
  news();
  EXPECT_EQ(shown("replay-end"), "(none)");
  EXPECT_EQ(go_to("1000"), "");
  run(100ms);
  EXPECT_THAT(news(), ElementsAre("20"));
  EXPECT_EQ(listener_.last_state().line, model::LineState::kEnded);
  EXPECT_EQ(shown("replay-state"), "ended");
  EXPECT_EQ(shown("replay-position"), "19.000");
}

TEST_F(ReplayControl, AfterTheEndItPlaysAgainAndCanBeSearched) {
  start();
  run(30s);
  news();
  EXPECT_EQ(shown("replay-state"), "ended");
  EXPECT_EQ(set("replay-state", "paused"), "the recording ended");
  EXPECT_EQ(set("replay-state", "playing"), "");
  EXPECT_EQ(listener_.last_state().line, model::LineState::kUp);
  run(1500ms);
  EXPECT_THAT(news(), ElementsAre("1", "2"));
  run(30s);
  news();
  EXPECT_EQ(go_to("17.5"), "");
  run(600ms);
  EXPECT_THAT(news(), ElementsAre("18", "19"));
  EXPECT_EQ(shown("replay-state"), "playing");
}

TEST_F(ReplayControl, DevicesThatLeftAtTheEndComeBack) {
  start({{"end", scalar("leave")}});
  run(30s);
  ASSERT_EQ(listener_.of<model::Leave>().size(), 1U);
  const auto joins = listener_.of<model::Join>().size();
  EXPECT_EQ(go_to("5"), "");
  run(100ms);
  EXPECT_EQ(listener_.of<model::Join>().size(), joins + 1);
}

TEST_F(ReplayControl, TheLongestGapHoldsBehindAJump) {
  listener_.files.files = {{"x.csv", "time,t\n0,1\n10,2\n1000,3\n1001,4\n"}};
  open(map({{"format", scalar("csv")},
            {"file", scalar("x.csv")},
            {"time", map({{"column", scalar("time")}, {"unit", scalar("s")}})},
            {"longest-gap", scalar("5s")},
            {"map", map({{"room", map({{"columns", map({{"t", sensor("temperature-1")}})}})}})}}));
  run(1s);
  news();
  EXPECT_EQ(go_to("6"), "") << "positions count the played time";
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("2"));
  run(4s);
  EXPECT_THAT(news(), ElementsAre("3"));
}

TEST_F(ReplayControl, ThePositionIsReportedOnceASecondAlsoBetweenSteps) {
  start({{"period", scalar("10ms")}});
  run(100ms);
  const auto before = listener_.of<model::State>().size();
  run(50ms);
  EXPECT_LE(listener_.of<model::State>().size(), before + 1);

  Listener slow;
  slow.files.files = {{"a.csv", "time,t\n0,1\n3600,2\n"}};
  const auto options = map({{"format", scalar("csv")},
                            {"file", scalar("a.csv")},
                            {"time", map({{"column", scalar("time")}, {"unit", scalar("s")}})},
                            {"map", map({{"room", map({{"columns", map({{"t", sensor("temperature-1")}})}})}})}});
  const auto made = make_log(slow, options, types_);
  ASSERT_TRUE(made.network->open());
  slow.time.run_for(1s);
  const auto reports = slow.of<model::State>().size();
  slow.time.run_for(10s);
  EXPECT_EQ(slow.of<model::State>().size(), reports + 10);
  EXPECT_EQ(slow.last_state().texts["replay-position"], "11.000");
}

TEST_F(ReplayControl, RefusalsSayWhatIsExpected) {
  start();
  EXPECT_THAT(go_to("5"), HasSubstr("has no position yet"));
  run(500ms);
  EXPECT_EQ(set("replay-state", "stop"), "'stop', expected playing or paused");
  for (const auto* speed : {"0", "-1", "fast", "1e7", "nan", ""})
    EXPECT_THAT(set("replay-speed", speed), HasSubstr("expected max or a factor from 0.001 to 1")) << speed;
  for (const auto* position : {"", "soon", "-5", "nan", "1e300", "+", "12:00"})
    EXPECT_THAT(go_to(position), HasSubstr("expected seconds")) << position;
  EXPECT_THAT(go_to("2026-01-31T12:00:00Z"), HasSubstr("has no dates"));
  EXPECT_THAT(set("volume", "1"), HasSubstr("a recording has no volume"));
  news();
  run(1s);
  EXPECT_THAT(news(), ElementsAre("2")) << "refusals change nothing";
}

TEST_F(ReplayControl, AFileThatIsGoneFailsTheLine) {
  start();
  run(2500ms);
  listener_.files.files.clear();
  EXPECT_THAT(go_to("0"), HasSubstr("a.csv"));
  ASSERT_EQ(listener_.failures.size(), 1U);
  EXPECT_THAT(set("replay-state", "paused"), HasSubstr("cannot be played now"));
  run(10s);
  listener_.files.files = {{"a.csv", table(1, 10)}, {"b.csv", table(11, 20)}};
  news();
  ASSERT_TRUE(made_.network->open());
  run(500ms);
  EXPECT_EQ(go_to("12"), "");
  run(1ms);
  EXPECT_EQ(news().back(), "13");
}

TEST_F(ReplayControl, EventsBeforeTheTargetDoNotHappenAgain) {
  listener_.files.files = {{"x.csv", "t,b\n1,1\n2,1\n3,\n4,\n"}};
  open(map(
      {{"format", scalar("csv")},
       {"file", scalar("x.csv")},
       {"period", scalar("1s")},
       {"map",
        map({{"room", map({{"columns", map({{"t", sensor("temperature-1")}, {"b", sensor("buttonCount-1")}})}})}})}}));
  run(1ms);
  news();
  EXPECT_EQ(go_to("2.5"), "");
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("3"));
}

/// A recording of our own: value n at second n.
class RecordingControl : public ReplayControl {
 protected:
  void SetUp() override {
    Writer writer;
    for (int i = 0; i < 100; ++i) {
      writer.set("proxy.wsn-1.7.sensor.light-1.value", std::to_string(i));
      if (i % 10 == 9) writer.close();
    }
    first = writer.now - 99s;
    last = writer.now;
    listener_.files.files["home.rec"] = writer.file();
    open(map({{"file", scalar("home.rec")}}));
    run(500ms);
  }
  std::string at(Duration from_first) const {
    return replay_time_text(std::chrono::floor<RecordTime>((first + from_first).time_since_epoch()));
  }
  WallTime first{}, last{};
};

TEST_F(RecordingControl, KnowsItsBeginningAndEndAtOnce) {
  EXPECT_EQ(shown("replay-begin"), at(0s));
  EXPECT_EQ(shown("replay-end"), at(99s));
  run(2s);
  EXPECT_NEAR(std::stod(shown("replay-position")), std::stod(at(2500ms)), 1);
}

TEST_F(RecordingControl, IsSearchedBySecondsAndByDate) {
  news();
  EXPECT_EQ(go_to(at(50500ms)), "");
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("50"));
  run(500ms);
  EXPECT_THAT(news(), ElementsAre("51"));
  EXPECT_EQ(go_to("20s"), "");
  run(1ms);
  EXPECT_THAT(news().back(), "20");
  EXPECT_EQ(go_to(base::iso_text(first + 70s)), "");
  run(1ms);
  EXPECT_THAT(news().back(), "70");
  EXPECT_THAT(go_to("1"), "") << "long before: the beginning";
  run(1ms);
  EXPECT_THAT(news(), ElementsAre("0"));
  EXPECT_THAT(go_to(at(100s)), HasSubstr("after the end"));
}

}  // namespace
}  // namespace rubicon::networks::log
