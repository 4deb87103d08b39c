#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/exit_codes.h"
#include "apps/rubicon/rates.h"
#include "apps/rubicon/settings.h"
#include "apps/rubicon/table.h"
#include "apps/rubicon/tuple_text.h"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;

WallTime at(double seconds) {
  return wall_time(seconds);
}

TEST(CliText, MembersOfAnotherKindReadAsNothing) {
  const auto odd = object_of(R"({"ok": 1, "id": 7, "text": true, "count": -1, "share": 0.5})");
  EXPECT_FALSE(flag_in(odd, "ok"));
  EXPECT_EQ(text_in(odd, "id"), "");
  EXPECT_EQ(number_in(odd, "text"), 0);
  EXPECT_EQ(count_in(odd, "count"), 0U);
  EXPECT_EQ(count_in(odd, "share"), 0U);
  const auto number = nlohmann::json(7);
  EXPECT_FALSE(flag_in(number, "ok"));
  const auto good = object_of(R"({"ok": true, "count": 18446744073709551615})");
  EXPECT_TRUE(flag_in(good, "ok"));
  EXPECT_EQ(count_in(good, "count"), 18446744073709551615U);
}

TEST(CliTable, AlignsColumnsByCharactersAndLeavesNoBlanksAtTheEnds) {
  Table table({"NAME", "VALUE", "X"});
  table.row({"Küche", "1"});
  table.row({"a", "200", "z"});
  EXPECT_EQ(table.text({}),
            "NAME   VALUE  X\n"
            "Küche  1\n"
            "a      200    z\n");
}

TEST(CliTable, CutsLinesAtTheWidthOfTheScreen) {
  Table table({"KEY", "VALUE"});
  table.row({"abc", "0123456789"});
  EXPECT_EQ(table.text({false, 9}), "KEY  VALU\nabc  0123\n");
  EXPECT_EQ(table.text({false, 4}), "KEY\nabc\n");
}

TEST(CliTable, CutsATextByCharacters) {
  EXPECT_EQ(cut("Küche", 2), "Kü");
  EXPECT_EQ(cut("Küche", 5), "Küche");
  EXPECT_EQ(cut("Küche", 0), "Küche");
}

TEST(CliTable, PaintsOnlyWithColour) {
  Table table({"QUALITY"});
  table.row({"stale"});
  EXPECT_EQ(table.text({}), "QUALITY\nstale\n");
  EXPECT_EQ(table.text({true, 0}), "\x1b[1mQUALITY\x1b[0m\n\x1b[33mstale\x1b[0m\n");
}

TEST(CliTable, NothingOfOutsidersSteersTheTerminal) {
  EXPECT_EQ(clean("a\x1b[2Jb\nc\x9f"), "a?[2Jb??");
  Table table({"VALUE"});
  table.row({"\x1b]0;owned\a"});
  EXPECT_EQ(table.text({}).find('\x1b'), std::string::npos);
}

TEST(CliText, SpellsAgesAndTimes) {
  EXPECT_EQ(age_text({}, at(100)), "-");
  EXPECT_EQ(age_text(at(99.7), at(100)), "0.3s");
  EXPECT_EQ(age_text(at(101), at(100)), "0.0s");
  EXPECT_EQ(age_text(at(100), at(125)), "25s");
  EXPECT_EQ(age_text(at(100), at(1000)), "15min");
  EXPECT_EQ(age_text(at(100), at(36100)), "10h");
  EXPECT_EQ(age_text(at(100), at(864100)), "10d");
  EXPECT_EQ(time_text({}), "-");
  EXPECT_EQ(time_text(at(1767225600.25)), "2026-01-01 00:00:00.250000 UTC");
  EXPECT_EQ(clock_text(at(1767225600.25)), "00:00:00.250");
  EXPECT_EQ(counted(1, "tuple"), "1 tuple");
  EXPECT_EQ(counted(0, "tuple"), "0 tuples");
}

client::Tuple tuple(std::string_view key, std::string_view value) {
  tuples::TupleView view;
  view.owner = OwnerId(7);
  view.creator = OwnerId(70001);
  view.key = key;
  view.value = value;
  view.media_type = "text/plain";
  view.sequence = 3;
  view.write_time = at(12.5);
  return client::Tuple(view);
}

TEST(CliText, ATupleInJsonHasTheNamesOfTheDaemonsLines) {
  EXPECT_EQ(dump(tuple_json(tuple("a.b", "on"))),
            R"({"owner":7,"key":"a.b","value":"on","mimetype":"text/plain","seq":3,"write":12.5,"user":0.0,)"
            R"("creator":70001,"expire":0.0})");
  auto lost = tuple("a.b", "\xff");
  lost.owner_present = false;
  const auto line = tuple_json(lost);
  EXPECT_EQ(line["value_hex"], "ff");
  EXPECT_FALSE(line.contains("value"));
  EXPECT_EQ(line["present"], false);
}

TEST(CliText, ReadsTheStatusBesideAPoint) {
  const auto states = states_of({tuple("proxy.n.d.sensor.x-1.status",
                                       R"({"quality":"stale","heard":5.5,"reason":"why","command":{"state":"sent"}})"),
                                 tuple("proxy.n.d.status", R"({"status":"reachable"})"),
                                 tuple("proxy.n.d.sensor.y-1.status", "no json")});
  ASSERT_EQ(states.size(), 2U);
  const auto& state = states.at({OwnerId(7), "proxy.n.d.sensor.x-1"});
  EXPECT_EQ(state.quality, "stale");
  EXPECT_EQ(state.heard, at(5.5));
  EXPECT_EQ(state.command, "sent");
  EXPECT_EQ(states.at({OwnerId(7), "proxy.n.d.sensor.y-1"}).quality, "");
}

TEST(CliText, HostileNumbersAreNoTimes) {
  EXPECT_EQ(wall_time(-1), WallTime{});
  EXPECT_EQ(wall_time(1e300), WallTime{});
  EXPECT_EQ(wall_time(std::numeric_limits<double>::quiet_NaN()), WallTime{});
}

TEST(CliExitCodes, EachWordForAnOutcomeHasItsCode) {
  for (const auto* good : {"confirmed", "assumed", "applied"}) EXPECT_EQ(exit_code_of(good), 0);
  EXPECT_EQ(exit_code_of("refused"), 3);
  EXPECT_EQ(exit_code_of("failed"), 4);
  EXPECT_EQ(exit_code_of("timed-out"), 5);
  EXPECT_EQ(exit_code_of("expired"), 6);
  EXPECT_EQ(exit_code_of("superseded"), 7);
  EXPECT_EQ(exit_code_of("no-such-owner"), 8);
  EXPECT_EQ(exit_code_of("queued"), 9);
  EXPECT_EQ(exit_code_of("sent"), 9);
  EXPECT_EQ(exit_code_of("nonsense"), 1);
}

TEST(CliRates, CountsByRoundAndSortsTheBusiestFirst) {
  Rates rates;
  for (int i = 0; i < 4; ++i) rates.count("b", at(10 + i));
  rates.count("a", at(20));
  rates.count("c", at(30));
  auto rows = rates.round(2s);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].name, "b");
  EXPECT_DOUBLE_EQ(rows[0].per_second, 2);
  EXPECT_EQ(rows[0].last, at(13));
  EXPECT_EQ(rows[1].name, "a");
  rates.count("c", at(40));
  rows = rates.round(1s);
  EXPECT_EQ(rows[0].name, "c");
  EXPECT_EQ(rows[0].total, 2U);
  EXPECT_DOUBLE_EQ(rows[1].per_second, 0);
}

TEST(CliRates, GroupsByDeviceNetworkAndIsland) {
  const std::string name = "7:proxy.wsn-1.7.sensor.light-1.value";
  EXPECT_EQ(group_of(name, "tuple"), name);
  EXPECT_EQ(group_of(name, "device"), "7:proxy.wsn-1.7");
  EXPECT_EQ(group_of(name, "network"), "7:proxy.wsn-1");
  EXPECT_EQ(group_of(name, "island"), "7");
  EXPECT_EQ(group_of("7:proxy.networks", "device"), "7:proxy.networks");
}

TEST(CliSettings, SaysWhereItLooks) {
  client::Options options;
  EXPECT_EQ(place_text(options), "domain 0 on lo");
  options.domain = 3;
  options.interfaces = {"eth0", "eth1"};
  options.tag = "home";
  options.peers = {"10.0.0.2"};
  EXPECT_EQ(place_text(options), "domain 3 on eth0, eth1, tag home, peers 10.0.0.2");
}

TEST(CliSettings, ASpanNeedsItsUnit) {
  EXPECT_EQ(wrong_with_span("250ms"), "");
  EXPECT_THAT(wrong_with_span("60"), testing::HasSubstr("expected a duration"));
  EXPECT_THAT(wrong_with_span("-1s"), testing::HasSubstr("expected a duration"));
  EXPECT_EQ(span_of("250ms"), 250ms);
  EXPECT_EQ(span_of("", 3s), 3s);
}

}  // namespace
}  // namespace rubicon::cli
