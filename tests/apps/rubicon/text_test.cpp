#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/doctor/signs.h"
#include "apps/rubicon/output/output.h"
#include "apps/rubicon/output/table.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/settings.h"
#include "model/json_members.h"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;

WallTime at(double seconds) {
  return model::time_from_seconds(seconds);
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

TEST(CliTable, PaintsOnlyWithColour) {
  Table table({"QUALITY"});
  table.row({"stale"});
  EXPECT_EQ(table.text({}), "QUALITY\nstale\n");
  Table reasons({"STATUS"});
  reasons.row({"unreachable: silent for 60s"});
  reasons.row({"down the hall"});
  EXPECT_EQ(reasons.text({true, 0}),
            "\x1b[1mSTATUS\x1b[0m\n\x1b[31munreachable: silent for 60s\x1b[0m\ndown the hall\n");
  EXPECT_EQ(table.text({true, 0}), "\x1b[1mQUALITY\x1b[0m\n\x1b[33mstale\x1b[0m\n");
}

TEST(CliTable, NothingOfOutsidersSteersTheTerminal) {
  EXPECT_EQ(printable("a\x1b[2Jb\nc\x9f"), "a?[2Jb??");
  EXPECT_EQ(printable("lamp\u202effo"), "lamp?ffo");
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
  ::setenv("TZ", "CET-1", 1);
  EXPECT_EQ(time_text(at(1767225600.25)), "2026-01-01 01:00:00.250 CET");
  EXPECT_EQ(clock_text(at(1767225600.25)), "01:00:00.250 CET");
  ::unsetenv("TZ");
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
  ::setenv("TZ", "CET-1", 1);
  EXPECT_EQ(model::dump(tuple_json(tuple("a.b", "on"))),
            R"({"owner":7,"key":"a.b","value":"on","mimetype":"text/plain","seq":3,"write":12.5,"user":0.0,)"
            R"("time":"1970-01-01T01:00:12.500000+01:00","creator":70001,"expire":0.0})");
  ::unsetenv("TZ");
  auto lost = tuple("a.b", "\xff");
  lost.owner_present = false;
  const auto line = tuple_json(lost);
  EXPECT_EQ(line["value_hex"], "ff");
  EXPECT_FALSE(line.contains("value"));
  EXPECT_EQ(line["present"], false);
}

TEST(CliText, APointInJsonHasItsQualityAndLineInOneForm) {
  client::Point point;
  point.tuple = tuple("proxy.n.d.sensor.x-1.value", "on");
  EXPECT_EQ(point_json(point), tuple_json(point.tuple)) << "a tuple that is no point";
  point.status = {"stale", "not heard for 3s", {}, at(5.5), at(4), ""};
  point.line = {"up", "", {}, 1, {}};
  const auto line = point_json(point);
  EXPECT_EQ(line["quality"], "stale");
  EXPECT_EQ(line["reason"], "not heard for 3s");
  EXPECT_EQ(line["heard"], 5.5);
  EXPECT_EQ(line["changed"], 4);
  EXPECT_EQ(line["line"], "up");
  EXPECT_EQ(quality_text(point), "stale: not heard for 3s");
}

TEST(CliText, SaysWhenALineIsTriedNext) {
  LineStatus line{"down", "why", at(50), 3, at(112)};
  EXPECT_EQ(next_attempt_text(line, at(100)), "next attempt in 12s");
  EXPECT_EQ(next_attempt_text(line, at(200)), "next attempt now");
  EXPECT_EQ(line_text(line), "down: why");
  line.line = "up";
  EXPECT_EQ(next_attempt_text(line, at(100)), "");
}

TEST(CliText, KnowsWhichPatternsNameValuesOfPoints) {
  EXPECT_EQ(points_of({OwnerId(7), "proxy.*.*.sensor.*.value"})->key, "proxy.*.*.sensor.*");
  EXPECT_FALSE(points_of({{}, "proxy.**"}));
  EXPECT_FALSE(points_of({{}, "proxy.*.*.sensor.*.status"}));
  EXPECT_TRUE(is_value_of_point("proxy.n.d.sensor.x-1.value"));
  EXPECT_FALSE(is_value_of_point("robot.a.b.c.d.value"));
}

TEST(CliText, RangesHaveNoExponents) {
  EXPECT_EQ(range_text(model::PointDescription{.minimum = 0, .maximum = 8.64e7}), "0..86400000");
  EXPECT_EQ(range_text(model::PointDescription{.minimum = -273.15}), "-273.15..");
  EXPECT_EQ(range_text(model::PointDescription{.minimum = 0, .words = {{0, "open"}, {1, "closed"}}}), "open|closed");
  EXPECT_EQ(range_text(model::PointDescription{}), "");
  Type type;
  type.minimum = 0;
  EXPECT_EQ(range_text(type), "0..");
  type.words = "off,on";
  EXPECT_EQ(range_text(type), "off|on");
}

TEST(CliText, ATypeIsFoundByNameQuantityUnitOrNumber) {
  const TypeCatalogue catalogue;
  const auto& co2 = *catalogue.find("co2");
  for (const auto* word : {"co2", "CO", "carbon dioxide", "ppm", "1037", "0x040d"})
    EXPECT_TRUE(found_by(co2, word)) << word;
  for (const auto* word : {"temperature", "40d", "1036", "°C"}) EXPECT_FALSE(found_by(co2, word)) << word;
  EXPECT_TRUE(found_by(*catalogue.find("temperature"), "°C"));
}

TEST(CliText, HostileNumbersAreNoTimes) {
  EXPECT_EQ(model::time_from_seconds(-1), WallTime{});
  EXPECT_EQ(model::time_from_seconds(1e300), WallTime{});
  EXPECT_EQ(model::time_from_seconds(std::numeric_limits<double>::quiet_NaN()), WallTime{});
}

TEST(CliExitCodes, EachWordForAnOutcomeHasItsCode) {
  for (const auto* good : {"confirmed", "assumed", "applied"}) EXPECT_EQ(exit_code_of(good), 0);
  EXPECT_EQ(exit_code_of("refused"), 3);
  EXPECT_EQ(exit_code_of("failed"), 4);
  EXPECT_EQ(exit_code_of("timed-out"), 5);
  EXPECT_EQ(exit_code_of("expired"), 6);
  EXPECT_EQ(exit_code_of("superseded"), 7);
  EXPECT_EQ(exit_code_of("no-such-owner"), 8);
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
  options.folder = "/srv/meet";
  EXPECT_EQ(place_text(options), "folder /srv/meet");
  EXPECT_EQ(place_options(options), "--folder /srv/meet");
  options.domain = 3;
  options.tag = "home";
  EXPECT_EQ(place_text(options), "folder /srv/meet, space d3-home");
  options.interfaces = {"eth0", "eth1"};
  options.peers = {"10.0.0.2"};
  EXPECT_EQ(place_text(options), "folder /srv/meet and domain 3 on eth0, eth1, tag home, peers 10.0.0.2");
  options.tcp = true;
  EXPECT_EQ(place_options(options),
            "--folder /srv/meet --domain 3 --interfaces eth0,eth1 --tcp --tag home --peers 10.0.0.2");
  options.folder.clear();
  options.engines = {client::Engine::kDds, client::Engine::kPeis};
  options.peis = {"lab", 8000, {"tcp://robot:8000"}, false};
  EXPECT_EQ(place_text(options),
            "domain 3 and PEIS network lab on eth0, eth1 over TCP, tag home, peers 10.0.0.2, connect tcp://robot:8000");
  EXPECT_EQ(place_options(options),
            "--engine dds,peis --peis-network lab --peis-connect tcp://robot:8000 --peis-multicast no --domain 3 "
            "--interfaces eth0,eth1 --tcp --tag home --peers 10.0.0.2");
  options.engines = {client::Engine::kPeis};
  EXPECT_EQ(place_text(options), "PEIS network lab on eth0, eth1, connect tcp://robot:8000");
  EXPECT_EQ(
      place_options(options),
      "--engine peis --peis-network lab --peis-connect tcp://robot:8000 --peis-multicast no --interfaces eth0,eth1");
}

/// What is wrong with the options of a command line; empty = nothing.
std::string wrong_with(std::vector<const char*> arguments) {
  CLI::App app;
  SettingsOptions options;
  options.add_to(app);
  arguments.insert(arguments.begin(), "rubicon");
  app.parse(static_cast<int>(arguments.size()), arguments.data());
  const auto settings = options.read();
  return settings ? std::string() : settings.error().text;
}

TEST(CliSettings, AnOptionThatWouldDoNothingIsRefused) {
  using testing::HasSubstr;
  EXPECT_THAT(wrong_with({"--engine", "peis", "--domain", "3"}),
              HasSubstr("--domain: only engine dds has this option, expected --engine with dds"));
  EXPECT_THAT(wrong_with({"--engine=dds", "--peis-network=x"}), HasSubstr("--peis-network: only engine peis"));
  EXPECT_THAT(wrong_with({"--peis-multicast", "no"}), HasSubstr("--peis-multicast: only engine peis"));
  EXPECT_THAT(wrong_with({"--engine", "peis", "--tcp"}), HasSubstr("--tcp: only engine dds"));
  EXPECT_THAT(wrong_with({"--engine", "dds,dds"}), HasSubstr("--engine: names an engine twice"));
  EXPECT_EQ(wrong_with({"--engine", "dds,peis", "--domain", "3", "--peis-network", "x"}), "");
}

TEST(CliSettings, TheEnvironmentMayServeSeveralEngines) {
  ASSERT_EQ(::setenv("RUBICON_DOMAIN", "3", 1), 0);
  ASSERT_EQ(::setenv("RUBICON_PEIS_NETWORK", "x", 1), 0);
  const auto on_peis = wrong_with({"--engine", "peis"}), on_dds = wrong_with({"--engine", "dds"});
  ASSERT_EQ(::unsetenv("RUBICON_DOMAIN"), 0);
  ASSERT_EQ(::unsetenv("RUBICON_PEIS_NETWORK"), 0);
  EXPECT_EQ(on_peis, "");
  EXPECT_EQ(on_dds, "");
}

TEST(CliSettings, ASpanNeedsItsUnit) {
  EXPECT_EQ(check_duration("250ms"), "");
  EXPECT_THAT(check_duration("60"), testing::HasSubstr("expected a duration"));
  EXPECT_THAT(check_duration("-1s"), testing::HasSubstr("expected a duration"));
  EXPECT_EQ(parse_duration_or("250ms"), 250ms);
  EXPECT_EQ(parse_duration_or("", 3s), 3s);
}

}  // namespace
}  // namespace rubicon::cli
