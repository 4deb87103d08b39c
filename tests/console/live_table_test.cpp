#include "console/live_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "console/draw_pace.h"
#include "island/virtual_island.h"

namespace rubicon::console {
namespace {

using namespace std::chrono_literals;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using Key = Stroke::Key;

constexpr std::string_view kRooms =
    "{living: {name: Living room, sensors: {temperature-1: {wave: constant, value: 21.5}}, actuators: {lamp-1: "
    "{behaviour: obey}}}, tank: {actuators: {boiler-1: {behaviour: ignore}}}}";

/// Without escape sequences of style.
std::string plain(std::string text) {
  for (auto at = text.find('\x1b'); at != text.npos; at = text.find('\x1b'))
    text.erase(at, text.find('m', at) - at + 1);
  return text;
}

std::size_t characters(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80; }));
}

/// The table as `run` makes it: its subscription is active.
class LiveTableTest : public testing::Test {
 protected:
  explicit LiveTableTest(std::string_view rooms = kRooms, std::string_view more = "")
      : world_(rooms, more),
        watching_(world_.space->subscribe({OwnerId(6541), "proxy.**"}, {}, [](const tuples::Event&) {})),
        log_(world_.log, "info", world_.time),
        table_(*world_.space, OwnerId(6541), "home", "proxy", log_) {
    ::setenv("TZ", "CET-1", 1);
    world_.time.run_for(2s);
  }
  ~LiveTableTest() override { ::unsetenv("TZ"); }

  std::vector<std::string> lines(ScreenSize size = {40, 120}) {
    std::vector<std::string> all;
    for (const auto& line : table_.frame(world_.time.wall_now(), size, "").lines) all.push_back(plain(line));
    return all;
  }
  std::string screen(ScreenSize size = {40, 120}) {
    std::string text;
    for (const auto& line : lines(size)) text += line + "\n";
    return text;
  }
  /// Draws after each stroke, as the terminal does.
  std::optional<std::string> type(std::string_view text, ScreenSize size = {40, 120}) {
    std::optional<std::string> entered;
    for (const char c : text) {
      screen(size);
      if (auto line = table_.press({Key::kText, std::string(1, c)})) entered = line;
    }
    return entered;
  }
  std::optional<std::string> press(Key key, ScreenSize size = {40, 120}) {
    screen(size);
    return table_.press({key});
  }

  island::VirtualIsland world_;
  tuples::Handle watching_;
  LiveLog log_;
  LiveTable table_;
};

TEST_F(LiveTableTest, ShowsNetworksDevicesAndValuesWithUnitAndQuality) {
  const auto text = screen();
  EXPECT_THAT(text, HasSubstr("Rubicon island 6541 home   2 of 2 devices reachable   01:00:02 CET"));
  EXPECT_THAT(text, ContainsRegex("▾ dummy-1 +up"));
  EXPECT_THAT(text, HasSubstr("  living  Living room  reachable"));
  EXPECT_THAT(text, ContainsRegex("temperature-1 +21\\.5 +°C +good +[0-9.]+s"));
  EXPECT_THAT(text, ContainsRegex("lamp-1 +unknown +-"));
}

TEST_F(LiveTableTest, ProposesACommandThatChangesSomethingAndTabTypesIt) {
  EXPECT_THAT(screen(), HasSubstr(" try: set proxy.dummy-1.living.actuator.lamp-1.command on "));
  EXPECT_FALSE(press(Key::kTab));
  EXPECT_THAT(screen(), HasSubstr("\n> set proxy.dummy-1.living.actuator.lamp-1.command on "));
  EXPECT_EQ(press(Key::kEnter), "set proxy.dummy-1.living.actuator.lamp-1.command on");
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.living.actuator.lamp-1.command", "on", 5s, {});
  world_.time.run_for(1s);
  EXPECT_THAT(screen(), HasSubstr(" try: set proxy.dummy-1.living.actuator.lamp-1.command off "));
  EXPECT_THAT(screen(), ContainsRegex("lamp-1 +on +good +[0-9.]+s +confirmed"));
}

TEST_F(LiveTableTest, TabTypesWhatTheLastFrameShowed) {
  EXPECT_THAT(screen(), HasSubstr(" try: set proxy.dummy-1.living.actuator.lamp-1.command on "));
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.living.actuator.lamp-1.command", "on", 5s, {});
  world_.time.run_for(1s);
  table_.press({Key::kTab});  // before the next frame, which proposes to switch it off
  EXPECT_EQ(table_.press({Key::kEnter}), "set proxy.dummy-1.living.actuator.lamp-1.command on");
}

TEST_F(LiveTableTest, ALineIsTypedAsBeforeWhateverItsFirstLetter) {
  for (const auto* line : {"set a.b c-d/e?", "quit", "help", "devices"}) {
    type(line);
    EXPECT_EQ(press(Key::kEnter), line);
  }
  type(":-x <>");
  EXPECT_EQ(press(Key::kEnter), "-x <>");
}

TEST_F(LiveTableTest, EveryLineIsAsWideAsTheTerminalAndTheyAreAsManyAsItsRows) {
  for (const auto size :
       {ScreenSize{40, 120}, ScreenSize{24, 80}, ScreenSize{12, 40}, ScreenSize{8, 20}, ScreenSize{50, 200}}) {
    for (const auto* keys : {"", "!", "!", "!?", "?/zzz"}) {
      type(keys, size);
      const auto all = lines(size);
      EXPECT_THAT(all, SizeIs(size.rows));
      for (const auto& line : all) EXPECT_EQ(characters(line), static_cast<std::size_t>(size.columns)) << line;
    }
    press(Key::kEscape);
  }
}

TEST_F(LiveTableTest, ShowsTheOutcomeOfACommandOnEightyColumns) {
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.tank.actuator.boiler-1.command", "on", 5s, {});
  world_.time.run_for(6s);
  EXPECT_THAT(screen({24, 80}), ContainsRegex("boiler-1 .* timed-out *\n"));
}

TEST_F(LiveTableTest, AFilterShowsWhatHasAllItsWordsAndWhatItStandsUnder) {
  type("/LIVING 21.5");
  const auto text = screen();
  EXPECT_THAT(text, HasSubstr("temperature-1"));
  EXPECT_THAT(text, HasSubstr("Living room"));
  EXPECT_THAT(text, HasSubstr("▾ dummy-1"));
  EXPECT_THAT(text, Not(HasSubstr("lamp-1    ")));
  EXPECT_THAT(text, Not(HasSubstr("boiler")));
  EXPECT_FALSE(press(Key::kEnter));  // it stays
  EXPECT_THAT(screen(), HasSubstr("filter: LIVING 21.5"));
  EXPECT_THAT(screen(), Not(HasSubstr("boiler")));
  press(Key::kEscape);
  EXPECT_THAT(screen(), HasSubstr("boiler"));
  type("/nothing fits");
  EXPECT_THAT(screen(), Not(HasSubstr("dummy-1   ")));
}

TEST_F(LiveTableTest, NetworksAndDevicesFold) {
  press(Key::kEnter);  // on the network
  EXPECT_THAT(screen(), ContainsRegex("▸ dummy-1"));
  EXPECT_THAT(screen(), Not(HasSubstr("Living room")));
  press(Key::kEnter);
  press(Key::kDown);
  press(Key::kEnter);  // on the first device
  EXPECT_THAT(screen(), HasSubstr("▸ living"));
  EXPECT_THAT(screen(), Not(HasSubstr("temperature-1")));
  EXPECT_THAT(screen(), HasSubstr("boiler-1"));
  type("-");
  EXPECT_THAT(screen(), Not(HasSubstr("boiler-1  ")));
  type("+");
  EXPECT_THAT(screen(), HasSubstr("temperature-1"));
}

TEST_F(LiveTableTest, EnterOnAnActuatorBeginsToSetIt) {
  for (int i = 0; i < 3; ++i) press(Key::kDown);
  press(Key::kEnter);
  type("on");
  EXPECT_EQ(press(Key::kEnter), "set proxy.dummy-1.living.actuator.lamp-1.command on");
}

TEST_F(LiveTableTest, TheLogStandsBelowTheTableThenAlone) {
  for (int i = 0; i < 60; ++i) Log(log_, "knx").warning("complaint " + std::to_string(i));
  EXPECT_THAT(screen(), HasSubstr("60 warnings"));
  EXPECT_THAT(screen(), Not(HasSubstr("complaint")));
  type("!");
  EXPECT_THAT(screen(), HasSubstr("knx: complaint 59"));
  EXPECT_THAT(screen(), HasSubstr("Living room"));
  type("!");
  EXPECT_THAT(screen(), Not(HasSubstr("Living room")));
  EXPECT_THAT(screen(), HasSubstr("complaint 30"));
  press(Key::kHome);
  EXPECT_THAT(screen(), HasSubstr("complaint 0 "));
  EXPECT_THAT(screen(), Not(HasSubstr("complaint 59")));
  press(Key::kEnd);
  EXPECT_THAT(screen(), HasSubstr("complaint 59"));
  type("!");
  EXPECT_THAT(screen(), Not(HasSubstr("complaint")));
}

TEST_F(LiveTableTest, HelpNamesTheKeys) {
  type("?");
  EXPECT_THAT(screen(), HasSubstr("PgDn"));
  press(Key::kEscape);
  EXPECT_THAT(screen(), Not(HasSubstr("PgDn")));
}

TEST_F(LiveTableTest, ALongCommandLineShowsItsEnd) {
  type(std::string(100, 'a') + "end", {24, 40});
  const auto all = lines({24, 40});
  EXPECT_THAT(all.back(), HasSubstr("aend"));
  EXPECT_EQ(characters(all.back()), 40U);
}

TEST_F(LiveTableTest, ALongAnswerTakesSomeRowsOfTheTable) {
  const auto with = [&](const std::string& answer, int rows) {
    std::string text;
    const auto lines = table_.frame(world_.time.wall_now(), {rows, 40}, answer).lines;
    EXPECT_EQ(lines.size(), static_cast<std::size_t>(rows));
    for (const auto& line : lines) text += plain(line) + "\n";
    return text;
  };
  const auto as = std::string(40, 'a'), bs = std::string(40, 'b');
  EXPECT_THAT(with(as + bs + "ccc", 24), HasSubstr("\n" + as + "\n" + bs + "\nccc "));
  EXPECT_THAT(with(as, 24), testing::ContainsRegex(" try: .*\n" + as + "\n>"));
  EXPECT_THAT(with(std::string(1000, 'a'), 24), HasSubstr("\n" + as.substr(1) + "…\n>"));
  EXPECT_THAT(with(std::string(1000, 'a'), 8), HasSubstr(as + "\n" + as.substr(1) + "…\n>"));
}

TEST_F(LiveTableTest, TheHelpIsWholeOnAnOrdinaryTerminalBesideALongAnswer) {
  type("?");
  const auto lines = table_.frame(world_.time.wall_now(), {24, 80}, std::string(1000, 'a')).lines;
  std::string text;
  for (std::size_t i = 0; i + 5 < lines.size(); ++i) text += plain(lines[i]) + "\n";  // without answer and prompt
  EXPECT_THAT(text, HasSubstr("\nThe live table "));
  EXPECT_THAT(text, HasSubstr("all sensors are sampled. "));
  EXPECT_THAT(text, Not(HasSubstr("…")));
}

/// Thirty devices with one point each: a title, a network and sixty rows.
class ManyRows : public LiveTableTest {
 protected:
  ManyRows() : LiveTableTest(rooms(), "  dummy-2: {type: dummy, simulate: {zoo: {name: A zoo}}}\n") {}
  static std::string rooms() {
    std::string text = "{";
    for (int i = 0; i < 30; ++i) text += "room" + std::to_string(i) + ": {sensors: {motion-1: {}}}, ";
    return text + "}";
  }
};

TEST_F(ManyRows, ScrollWithTheKeysOfAPager) {
  const ScreenSize size{24, 80};
  EXPECT_THAT(screen(size), HasSubstr("1-19 of 63"));
  EXPECT_THAT(screen(size), Not(HasSubstr("room12")));
  for (int i = 0; i < 19; ++i) press(Key::kDown, size);
  EXPECT_THAT(screen(size), HasSubstr("2-20 of 63"));
  press(Key::kPageDown, size);
  EXPECT_THAT(screen(size), HasSubstr("21-39 of 63"));
  press(Key::kEnd, size);
  EXPECT_THAT(screen(size), HasSubstr("45-63 of 63"));
  EXPECT_THAT(screen(size), HasSubstr("A zoo"));
  press(Key::kPageUp, size);
  press(Key::kHome, size);
  EXPECT_THAT(screen(size), HasSubstr("1-19 of 63"));
  press(Key::kUp, size);
  EXPECT_THAT(screen(size), HasSubstr("1-19 of 63"));
}

TEST_F(ManyRows, ATallerScreenShowsMoreAndTheSelectionStaysVisible) {
  press(Key::kEnd, {24, 80});
  EXPECT_THAT(screen({60, 80}), HasSubstr("9-63 of 63"));
  EXPECT_THAT(screen({12, 80}), HasSubstr("57-63 of 63"));
  EXPECT_THAT(screen({100, 80}), HasSubstr("1-63 of 63"));
}

TEST_F(ManyRows, NumbersInNamesAreNumbers) {
  const auto text = screen({100, 80});
  EXPECT_LT(text.find("  room2  "), text.find("  room10  "));
}

TEST_F(ManyRows, SortedByNameTheNetworksDoNotMatter) {
  type(">");
  const auto text = screen({24, 80});
  EXPECT_THAT(text, HasSubstr("sorted: name"));
  EXPECT_THAT(text, Not(HasSubstr(" CET")));  // no room for it
  EXPECT_LT(text.find("dummy-2.zoo  A zoo"), text.find("dummy-1.room0"));
  type("<");
  EXPECT_THAT(screen({24, 80}), HasSubstr("▾ dummy-1"));
}

TEST_F(ManyRows, TheTitleCountsWarningsOnEightyColumnsHoweverItIsSorted) {
  for (int i = 0; i < 2; ++i) Log(log_, "knx").warning("complaint");
  EXPECT_THAT(screen({24, 80}), HasSubstr("Rubicon island 6541 home   31 of 31 devices reachable   2 warnings"));
  type("<");
  EXPECT_THAT(screen({24, 80}), HasSubstr("Rubicon island 6541 home   31/31 reachable   sorted: trouble   2 warnings"));
  type("/a filter that has many words and is longer than the screen has room for it", {24, 80});
  EXPECT_THAT(screen({24, 80}), HasSubstr("sorted: trouble   2 warnings   fil…"));
}

TEST_F(LiveTableTest, SortedByTroubleWhatFailedComesFirst) {
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.tank.actuator.boiler-1.command", "on", 5s, {});
  world_.time.run_for(6s);
  type("<");
  const auto text = screen();
  EXPECT_THAT(text, HasSubstr("sorted: trouble"));
  EXPECT_LT(text.find("dummy-1.tank"), text.find("dummy-1.living"));
}

TEST_F(LiveTableTest, SortedByLatestWhatWasHeardLastComesFirst) {
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.tank.actuator.boiler-1.command", "on", 5s, {});
  world_.time.run_for(6s);
  type(">>");
  const auto text = screen();
  EXPECT_THAT(text, HasSubstr("sorted: latest"));
  EXPECT_LT(text.find("dummy-1.living"), text.find("dummy-1.tank"));
}

TEST_F(ManyRows, TheSelectedRowStaysSelectedWhenRowsAboveItGo) {
  for (int i = 0; i < 43; ++i) press(Key::kDown, {24, 80});
  const auto before = table_.frame(world_.time.wall_now(), {24, 80}, "").lines;
  const auto reversed = [](const std::vector<std::string>& all) {
    const auto found =
        std::find_if(all.begin(), all.end(), [](const auto& line) { return line.starts_with("\x1b[7m"); });
    return found == all.end() ? std::string() : plain(*found);
  };
  EXPECT_NE(reversed(before), "");
  type("/room2", {24, 80});
  press(Key::kEnter, {24, 80});
  EXPECT_EQ(reversed(table_.frame(world_.time.wall_now(), {24, 80}, "").lines).substr(0, 20),
            reversed(before).substr(0, 20));
}

TEST(LiveTable, SaysSomethingWhereNothingIs) {
  island::VirtualIsland world("{}");
  LiveLog log(world.log, "info", world.time);
  LiveTable table(*world.space, OwnerId(6541), "home", "proxy", log);
  std::string text;
  for (const auto& line : table.frame(world.time.wall_now(), {}, "an answer").lines) text += line + "\n";
  EXPECT_THAT(text, HasSubstr("0 of 0 devices reachable"));
  EXPECT_THAT(text, HasSubstr(" try: help"));
  EXPECT_THAT(text, HasSubstr("nothing to show"));
  EXPECT_THAT(text, HasSubstr("\nan answer "));
}

TEST(DrawPaceTest, ManyStrokesOfATurnAreDrawnOnceAndDrawingLeavesTheLoopItsTime) {
  VirtualScheduler time;
  int drawn = 0;
  Duration takes = 200ms;
  DrawPace pace(time, [&] {
    ++drawn;
    return takes;
  });
  for (int i = 0; i < 100; ++i) pace.ask();
  EXPECT_EQ(drawn, 0) << "in a later turn";
  time.run_ready();
  EXPECT_EQ(drawn, 1);
  for (int i = 0; i < 199; ++i) {
    pace.ask();
    time.run_for(10ms);
  }
  EXPECT_EQ(drawn, 1) << "a tenth of the time";
  time.run_for(10ms);
  EXPECT_EQ(drawn, 2);
}

TEST(DrawPaceTest, AStrokeIsDrawnAtOnceAndWithoutOneItIsDrawnNowAndThen) {
  VirtualScheduler time;
  int drawn = 0;
  DrawPace pace(time, [&] {
    ++drawn;
    return Duration{};
  });
  for (int i = 1; i <= 5; ++i) {
    pace.ask();
    time.run_ready();
    EXPECT_EQ(drawn, i);
  }
  time.run_for(2s);
  EXPECT_EQ(drawn, 9);
}

/// Keeps what it is given.
struct Kept final : base::LogSink {
  void write(base::LogLevel, std::string_view, std::string_view text) override { lines.emplace_back(text); }
  std::vector<std::string> lines;
};

TEST(LiveLogTest, WhileTheScreenIsThereNothingIsWrittenIntoItAndComplaintsComeAfterwards) {
  VirtualScheduler time;
  Kept behind;
  LiveLog log(behind, "info", time);
  Log(log, "a").info("before");
  log.hold();
  Log(log, "a").info("meanwhile");
  Log(log, "a").warning("complaint");
  Log(log, "a").debug("too small");
  EXPECT_THAT(behind.lines, testing::ElementsAre("before"));
  log.release();
  Log(log, "a").info("after");
  EXPECT_THAT(behind.lines, testing::ElementsAre("before", "complaint", "after"));
  EXPECT_THAT(log.lines(), SizeIs(4));
}

TEST(LiveLogTest, KeepsTheLastLinesOnly) {
  VirtualScheduler time;
  Kept behind;
  LiveLog log(behind, "warning", time);
  log.hold();
  for (int i = 0; i < 3000; ++i) Log(log, "a").error(std::string(5000, 'x'));
  EXPECT_THAT(log.lines(), SizeIs(LiveLog::kKept));
  EXPECT_LE(log.lines().back().text.size(), LiveLog::kMostBytes + 3);
  log.release();
  EXPECT_THAT(behind.lines, SizeIs(LiveLog::kKept));
}

}  // namespace
}  // namespace rubicon::console
