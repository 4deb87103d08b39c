#include "apps/rubicon/live/live_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "apps/rubicon/live/screen.h"
#include "island/virtual_island.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::cli::live {
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

/// The table as `top` makes it: its subscription is active.
class LiveTableTest : public testing::Test {
 protected:
  explicit LiveTableTest(std::string_view rooms = kRooms, std::string_view more = "")
      : world_(rooms, more),
        watching_(world_.space->subscribe({std::nullopt, "proxy.**"}, {}, [](const tuples::Event&) {})),
        table_(LiveSource(*world_.space, std::nullopt, "proxy"), log_, "folder /run/rubicon") {
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

  void complain(const std::string& text) { log_.add({world_.time.wall_now(), true, text}); }

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
  EXPECT_THAT(screen(), HasSubstr(" try: set dummy-1.living.lamp-1 on "));
  EXPECT_FALSE(press(Key::kTab));
  EXPECT_THAT(screen(), HasSubstr("\n> set dummy-1.living.lamp-1 on "));
  EXPECT_EQ(press(Key::kEnter), "set dummy-1.living.lamp-1 on");
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.living.actuator.lamp-1.command", "on", 5s, {});
  world_.time.run_for(1s);
  EXPECT_THAT(screen(), HasSubstr(" try: set dummy-1.living.lamp-1 off "));
  EXPECT_THAT(screen(), ContainsRegex("lamp-1 +on +good +[0-9.]+s +confirmed"));
}

TEST_F(LiveTableTest, TabTypesWhatTheLastFrameShowed) {
  EXPECT_THAT(screen(), HasSubstr(" try: set dummy-1.living.lamp-1 on "));
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.living.actuator.lamp-1.command", "on", 5s, {});
  world_.time.run_for(1s);
  table_.press({Key::kTab});  // before the next frame, which proposes to switch it off
  EXPECT_EQ(table_.press({Key::kEnter}), "set dummy-1.living.lamp-1 on");
}

TEST_F(LiveTableTest, ALineIsTypedAsBeforeWhateverItsFirstLetter) {
  for (const auto* line : {"set a.b c-d/e?", "get quit", "inbox", "devices"}) {
    type(line);
    EXPECT_EQ(press(Key::kEnter), line);
  }
  type(":-x <>");
  EXPECT_EQ(press(Key::kEnter), "-x <>");
}

TEST_F(LiveTableTest, OneLetterEndsItUnlessItStandsInALine) {
  EXPECT_EQ(type("q"), LiveView::kQuit);
  EXPECT_FALSE(type("setq"));
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
  EXPECT_EQ(press(Key::kEnter), "set dummy-1.living.lamp-1 on");
}

TEST_F(LiveTableTest, TheLogStandsBelowTheTableThenAlone) {
  for (int i = 0; i < 60; ++i) complain("knx: complaint " + std::to_string(i));
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
  EXPECT_THAT(with("one\ntwo", 24), testing::ContainsRegex("\none *\ntwo *\n>"));
  EXPECT_THAT(with("1\n2\n3\n4\n5", 24), testing::ContainsRegex("\n3 *\n4 *! has more\n>")) << "the rest is in the log";
}

TEST_F(LiveTableTest, TheHelpIsWholeOnAnOrdinaryTerminalBesideALongAnswer) {
  type("?");
  const auto lines = table_.frame(world_.time.wall_now(), {24, 80}, std::string(1000, 'a')).lines;
  std::string text;
  for (std::size_t i = 0; i + 5 < lines.size(); ++i) text += plain(lines[i]) + "\n";  // without answer and prompt
  EXPECT_THAT(text, HasSubstr("\nThe live table "));
  EXPECT_THAT(text, HasSubstr("all sensors are sampled "));
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
  for (int i = 0; i < 2; ++i) complain("knx: complaint");
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

TEST_F(LiveTableTest, SortedByBusiestWhatIsSetMostOftenComesFirstWithItsRate) {
  table_.source().count(OwnerId(6541), "proxy.dummy-1.tank.actuator.boiler-1.value", world_.time.wall_now());
  table_.source().end_round(2s);
  type(">>>");
  const auto text = screen();
  EXPECT_THAT(text, HasSubstr("sorted: busiest"));
  EXPECT_LT(text.find("dummy-1.tank"), text.find("dummy-1.living"));
  EXPECT_THAT(text, ContainsRegex("QUALITY +/S"));
  EXPECT_THAT(text, ContainsRegex("boiler-1 .* 0\\.5"));
  table_.source().end_round(2s);
  EXPECT_THAT(screen(), Not(ContainsRegex("boiler-1 .* 0\\.5")));
}

/// Another island beside the one of the table.
class TwoIslands : public LiveTableTest {
 protected:
  TwoIslands()
      : link_(world_.ecology.join(OwnerId(7)).value()),
        other_(std::make_unique<TupleSpace>(OwnerId(7), world_.time, *link_)) {
    for (const auto& [key, value] : std::initializer_list<std::pair<const char*, const char*>>{
             {"proxy.networks", "{}"},
             {"proxy.wsn-1.status", R"({"line":"up"})"},
             {"proxy.wsn-1.7.status", R"({"status":"reachable"})"},
             {"proxy.wsn-1.7.sensor.light-1.value", "42"},
             {"proxy.wsn-1.7.sensor.light-1.status", R"({"quality":"good"})"}})
      EXPECT_TRUE(other_->set(key, value));
    world_.time.run_for(1s);
  }

  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> other_;
};

TEST_F(TwoIslands, StandInOneTableWithTheirIds) {
  const auto text = screen();
  EXPECT_THAT(text, HasSubstr("Rubicon 2 islands   3 of 3 devices reachable"));
  EXPECT_THAT(text, ContainsRegex("▾ 7:wsn-1 +up"));
  EXPECT_THAT(text, ContainsRegex("▾ 6541:dummy-1 +up"));
  EXPECT_THAT(text, HasSubstr(" try: set 6541:dummy-1.living.lamp-1 on "));
  type("/7:wsn");
  EXPECT_THAT(screen(), ContainsRegex("light-1 +42"));
  EXPECT_THAT(screen(), Not(HasSubstr("Living room")));
}

TEST_F(TwoIslands, OneThatLeftIsAbsentForAWhileAndThenGone) {
  other_.reset();
  link_.reset();
  world_.time.run_for(1s);
  EXPECT_THAT(screen(), HasSubstr("Rubicon 2 islands, 1 absent   2 of 3 devices reachable"));
  EXPECT_THAT(screen(), ContainsRegex("▾ 7:wsn-1 +absent"));
  EXPECT_THAT(screen(), ContainsRegex("light-1 +42 +network-down"));
  world_.time.run_for(tuples::kOwnerGrace + 1s);
  EXPECT_THAT(screen(), HasSubstr("Rubicon island 6541 home   2 of 2 devices reachable"));
  EXPECT_THAT(screen(), ContainsRegex("▾ dummy-1 +up"));
}

TEST(LiveTable, SaysWhereItLookedWhereNothingIs) {
  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  const auto link = ecology.join(OwnerId(65536)).value();
  TupleSpace space(OwnerId(65536), time, *link);
  LiveLog log;
  LiveTable table(LiveSource(space, std::nullopt, "proxy"), log, "folder /run/rubicon");
  std::string text;
  for (const auto& line : table.frame(time.wall_now(), {}, "an answer").lines) text += line + "\n";
  EXPECT_THAT(text, HasSubstr("no island yet in folder /run/rubicon "));
  EXPECT_THAT(text, HasSubstr(" try: islands"));
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

TEST(LiveLogTest, KeepsTheLastLinesAndCountsComplaints) {
  LiveLog log;
  for (int i = 0; i < 3000; ++i) log.add({{}, i % 2 == 0, std::string(5000, 'x')});
  EXPECT_THAT(log.lines(), SizeIs(LiveLog::kKept));
  EXPECT_EQ(log.lines().back().text.size(), LiveLog::kMaxByteCount);
  EXPECT_EQ(log.complaints(), 1500U);
}

}  // namespace
}  // namespace rubicon::cli::live
