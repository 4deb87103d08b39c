#include "runtime/live_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "runtime/virtual_island.h"

namespace rubicon::runtime {
namespace {

using namespace std::chrono_literals;
using testing::ContainsRegex;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

constexpr std::string_view kRooms =
    "{living: {name: Living room, sensors: {temperature-1: {wave: constant, value: 21.5}}, actuators: {lamp-1: "
    "{behaviour: obey}}}, tank: {actuators: {boiler-1: {behaviour: ignore}}}}";

/// The table as `run` makes it: its subscription is active.
class LiveTableTest : public testing::Test {
 protected:
  explicit LiveTableTest(std::string_view rooms = kRooms)
      : world_(rooms),
        watching_(world_.space->subscribe({OwnerId(6541), "proxy.**"}, {}, [](const tuples::Event&) {})),
        table_(*world_.space, OwnerId(6541), "home", "proxy") {
    world_.time.run_for(2s);
  }

  std::string screen(ScreenSize size = {40, 120}) { return table_.render(world_.time.wall_now(), size); }

  VirtualIsland world_;
  tuples::Handle watching_;
  LiveTable table_;
};

TEST_F(LiveTableTest, ShowsNetworksDevicesAndValuesWithUnitAndQuality) {
  const auto text = screen();
  EXPECT_THAT(text, HasSubstr("Rubicon island 6541 home   2 of 2 devices reachable   00:00:02 UTC"));
  EXPECT_THAT(text, ContainsRegex("dummy-1 +up"));
  EXPECT_THAT(text, HasSubstr("proxy.dummy-1.living  Living room  reachable"));
  EXPECT_THAT(text, ContainsRegex("temperature-1 +21\\.5 +Cel +good +[0-9.]+s"));
  EXPECT_THAT(text, ContainsRegex("lamp-1 +unknown +-"));
}

TEST_F(LiveTableTest, ProposesACommandThatChangesSomething) {
  EXPECT_THAT(screen(), HasSubstr(" try: set proxy.dummy-1.living.actuator.lamp-1.command on "));
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.living.actuator.lamp-1.command", "on", 5s, {});
  world_.time.run_for(1s);
  EXPECT_THAT(screen(), HasSubstr(" try: set proxy.dummy-1.living.actuator.lamp-1.command off "));
  EXPECT_THAT(screen(), ContainsRegex("lamp-1 +on +good +[0-9.]+s +confirmed"));
}

TEST_F(LiveTableTest, EveryLineFitsTheTerminal) {
  for (const auto size : {ScreenSize{40, 120}, ScreenSize{24, 80}, ScreenSize{12, 40}, ScreenSize{8, 20}}) {
    auto text = screen(size);
    EXPECT_LE(std::count(text.begin(), text.end(), '\n') + 1, size.rows);
    for (const auto* sequence : {"\x1b[1m", "\x1b[0m"}) {
      for (auto at = text.find(sequence); at != text.npos; at = text.find(sequence)) text.erase(at, 4);
    }
    for (std::size_t begin = 0; begin < text.size();) {
      const auto end = std::min(text.find('\n', begin), text.size());
      EXPECT_EQ(end - begin, static_cast<std::size_t>(size.columns));
      begin = end + 1;
    }
  }
}

TEST_F(LiveTableTest, CountsDevicesThatDoNotFit) {
  EXPECT_THAT(screen({12, 120}), HasSubstr("1 of 2 devices do not fit"));
  EXPECT_THAT(screen({12, 120}), Not(HasSubstr("proxy.dummy-1.tank")));
  EXPECT_THAT(screen({40, 120}), Not(HasSubstr("do not fit")));
}

TEST_F(LiveTableTest, ShowsTheOutcomeOfACommandOnEightyColumns) {
  world_.space->set_remote(OwnerId(6541), "proxy.dummy-1.tank.actuator.boiler-1.command", "on", 5s, {});
  world_.time.run_for(6s);
  EXPECT_THAT(screen({24, 80}), ContainsRegex("boiler-1 .* timed-out *\n"));
}

TEST(LiveTable, ASmallScreenShowsDevicesOfEveryNetwork) {
  VirtualIsland world("{a: {}, b: {}, c: {}, d: {}}", "  dummy-2: {type: dummy, simulate: {e: {}, f: {}}}\n");
  const auto all = world.space->subscribe({OwnerId(6541), "proxy.**"}, {}, [](const tuples::Event&) {});
  world.time.run_for(1s);
  LiveTable table(*world.space, OwnerId(6541), "home", "proxy");
  const auto text = table.render(world.time.wall_now(), {12, 80});
  EXPECT_THAT(text, HasSubstr("proxy.dummy-1.a"));
  EXPECT_THAT(text, HasSubstr("proxy.dummy-2.e"));
  EXPECT_THAT(text, HasSubstr("4 of 6 devices do not fit"));
}

TEST(LiveTable, SaysSomethingWhereNothingIs) {
  VirtualIsland world("{}");
  LiveTable table(*world.space, OwnerId(6541), "home", "proxy");
  const auto text = table.render(world.time.wall_now(), {});
  EXPECT_THAT(text, HasSubstr("0 of 0 devices reachable"));
  EXPECT_THAT(text, HasSubstr(" try: help"));
}

TEST(Fitted, CutsAndPadsByCharacters) {
  EXPECT_EQ(fitted("abc", 5), "abc  ");
  EXPECT_EQ(fitted("abcdef", 3), "abc");
  EXPECT_EQ(fitted("K\xc3\xbc"
                   "che",
                   3),
            "K\xc3\xbc"
            "c");
  EXPECT_EQ(fitted("", 0), "");
}

TEST(Fitted, LetsNothingThroughThatSteersATerminal) {
  EXPECT_EQ(fitted("a\x1b[2Jb\nc\x7f", 8), "a?[2Jb?c");
  EXPECT_EQ(fitted("\xc2\x9b"
                   "31m",
                   4),
            "?31m");
  EXPECT_EQ(fitted("\xff\xc3", 2), "??");
}

}  // namespace
}  // namespace rubicon::runtime
