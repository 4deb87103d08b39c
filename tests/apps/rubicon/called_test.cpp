#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/commands/completion.h"
#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// An island whose devices have the names of people, for all tests.
class Called : public testing::Test {
 protected:
  struct World {
    PrivateNetwork alone;
    Folder folder;
    std::unique_ptr<Process> home;
  };

  static std::string home_text() {
    return R"(island: {id: 6541, name: home}
state: {file: home.state}
history: {file: home.history}
networks:
  dummy-1:
    type: dummy
    devices:
      kitchen: {area: Kitchen}
      living: {area: Living}
      left: {area: Living}
    simulate:
      living:
        name: Living room
        sensors: {light-1: {wave: sine, low: 40, high: 320, period: 5s}}
        actuators: {lamp-1: {}, lamp-2: {}}
      kitchen:
        name: "Küche/oben"
        sensors: {temperature-1: {}, humidity-1: {}}
      left:
        name: Blind
        actuators: {blindPosition-1: {}, switch-1: {}}
      right:
        name: Blind
        actuators: {blindPosition-1: {}}
)";
  }
  static void SetUpTestSuite() {
    world_ = std::make_unique<World>();
    if (world_->alone.entered()) world_->home = started(world_->folder.write("home.yaml", home_text()));
  }
  static void TearDownTestSuite() { world_.reset(); }
  void SetUp() override {
    if (!world_->alone.entered()) GTEST_SKIP() << world_->alone.reason();
  }
  static std::unique_ptr<World> world_;
};
std::unique_ptr<Called::World> Called::world_;

constexpr const char* kLight = "6541:proxy.dummy-1.living.sensor.light-1.value";

TEST_F(Called, GetTakesTheNameOfADeviceAndTheTypeOfAPoint) {
  for (const auto* name : {"Living room.light-1", "living ROOM.light", "living.light", "home:Living room.light-1"}) {
    const auto found = rubicon({"get", name, "--json", "--any-quality"});
    EXPECT_EQ(found.code, 0) << found.errors;
    ASSERT_EQ(lines_of(found).size(), 1U) << name;
    EXPECT_EQ(lines_of(found).front()["key"], "proxy.dummy-1.living.sensor.light-1.value");
  }
  for (const auto* island : {"home", "6541"})
    EXPECT_EQ(rubicon({"get", "--island", island, "Küche/oben.temperature", "--any-quality"}).code, 0) << island;
  EXPECT_EQ(rubicon({"get", "--island", "attic", "living.light-1"}).code, 8);
  EXPECT_EQ(rubicon({"get", "--island", "home", "7:living.light-1"}).code, 2);
}

TEST_F(Called, WhatSeveralAreCalledIsAskedFor) {
  const auto lamps = rubicon({"get", "Living room.lamp"});
  EXPECT_EQ(lamps.code, 2);
  EXPECT_THAT(lamps.errors, AllOf(HasSubstr("'Living room.lamp' is ambiguous"), HasSubstr("actuator.lamp-1.value\n"),
                                  HasSubstr("actuator.lamp-2.value")));
  const auto blinds = rubicon({"set", "Blind.blindPosition", "10"});
  EXPECT_EQ(blinds.code, 2);
  EXPECT_THAT(blinds.errors, AllOf(HasSubstr("dummy-1.left."), HasSubstr("dummy-1.right.")));
}

TEST_F(Called, AnErrorHasTheNameAsItWasTypedAndOnesThatAreNear) {
  const auto typed = rubicon({"get", "Küche/obn.temperature-1"});
  EXPECT_EQ(typed.code, 8);
  EXPECT_THAT(typed.errors, AllOf(HasSubstr("no tuple Küche/obn.temperature-1"),
                                  HasSubstr("did you mean 'Küche/oben.temperature-1'?")));
  EXPECT_THAT(rubicon({"get", "Küche"}).errors, Not(HasSubstr("\\x")));
  EXPECT_THAT(rubicon({"ls", "Living rom.light-1"}).errors, HasSubstr("did you mean 'Living room.light-1'?"));
  EXPECT_THAT(rubicon({"get", "Living room"}).errors, HasSubstr("name a point of it, such as 'Living room.light-1'"));
  EXPECT_EQ(rubicon({"get", "a..b"}).code, 2);
  EXPECT_EQ(rubicon({"get", "Living room.*"}).code, 2);
}

TEST_F(Called, SetTakesNamesAndSaysWhatCanOnlyBeRead) {
  const auto set = rubicon({"set", "Living room.lamp-1", "ON"});
  EXPECT_EQ(set.code, 0) << set.errors;
  EXPECT_THAT(set.output, StartsWith("6541:proxy.dummy-1.living.actuator.lamp-1.command confirmed"));
  EXPECT_EQ(rubicon({"set", "--island", "home", "left.switch", "on"}).code, 0);
  const auto kitchen = rubicon({"set", "kitchen.temperature", "5"});
  EXPECT_EQ(kitchen.code, 8);
  EXPECT_THAT(kitchen.errors, HasSubstr("6541:proxy.dummy-1.kitchen.sensor.temperature-1 can only be read; of kitchen "
                                        "can be set: 'kitchen.rate'"));
  EXPECT_THAT(rubicon({"set", "Living room.light", "5"}).errors,
              HasSubstr("can only be read; of living can be set: 'living.lamp-1', 'living.lamp-2' or 'living.rate'"));
}

TEST_F(Called, LsAndWatchTakeAllThatAreCalledSo) {
  const auto both = lines_of(rubicon({"ls", "Blind.blindPosition", "--json"}));
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(lines_of(rubicon({"ls", "Living room.lamp*", "--json"})).size(), 2U);
  EXPECT_EQ(lines_of(rubicon({"ls", "--island", "home", "Living room.*", "--json"})).size(), 4U);
  EXPECT_EQ(lines_of(rubicon({"ls", "Living.*", "--json"})).size(), 4U) << "the device before the room";
  const auto event = rubicon({"watch", "Living room.light", "--count", "1", "--island", "home"});
  EXPECT_EQ(event.code, 0) << event.errors;
  EXPECT_THAT(event.output, HasSubstr(kLight));
  const auto blinds = lines_of(rubicon({"watch", "Blind.blind*", "--passive", "--count", "2", "--json"}));
  ASSERT_EQ(blinds.size(), 2U);
  EXPECT_NE(blinds[0]["key"], blinds[1]["key"]);
  EXPECT_EQ(rubicon({"watch", "Nobody here.light-1", "--for", "100ms"}).code, 8);
}

TEST_F(Called, DescribeAndRenameTakeNamesAndAnIsland) {
  EXPECT_THAT(rubicon({"describe", "küche/OBEN"}).output, HasSubstr("6541:proxy.dummy-1.kitchen"));
  EXPECT_THAT(rubicon({"describe", "Kitchen", "--island", "home"}).output, HasSubstr("6541:proxy.dummy-1.kitchen"));
  EXPECT_EQ(rubicon({"describe", "Blind"}).code, 2);
  const auto renamed = rubicon({"rename", "--island", "6541", "right", "Blind, south"});
  EXPECT_EQ(renamed.code, 0) << renamed.errors;
  EXPECT_EQ(rubicon({"get", "Blind, south.blindPosition", "--any-quality"}).code, 0);
  EXPECT_EQ(rubicon({"rename", "Blind, south", ""}).code, 0);
}

std::string in_bash(const std::string& line) {
  return support::run_to_end(
             {"env", "RUBICON_PATIENCE=30s", "LINE=" + line, "bash", "-c",
              "PATH=" RUBICON_BINARY_DIR "/bin:$PATH; . <(rubicon completion bash); COMP_LINE=$LINE; "
              "COMP_POINT=${#COMP_LINE}; compopt() { :; }; _rubicon; printf '%s\\n' \"${COMPREPLY[@]}\""})
      .output;
}

/// A name of a lamp of the living room, as the page gives it.
class CalledPoints : public Called {
 protected:
  void SetUp() override {
    Called::SetUp();
    if (IsSkipped()) return;
    ASSERT_EQ(rubicon({"set", "proxy.overview", R"({"names":{"dummy-1.living.actuator.lamp-1":"Reading lamp"}})"}).code,
              0);
  }
  void TearDown() override {
    if (IsSkipped()) return;
    EXPECT_EQ(rubicon({"set", "proxy.overview", R"({"names":{"dummy-1.living.actuator.lamp-1":""}})"}).code, 0);
  }
};

TEST_F(CalledPoints, AreSetAndReadByTheNamesThatPeopleGave) {
  for (const auto* name : {"Reading lamp", "Living room.Reading lamp", "living.reading LAMP", "home:Reading lamp"}) {
    const auto set = rubicon({"set", name, "on"});
    EXPECT_EQ(set.code, 0) << name << set.errors;
    EXPECT_THAT(set.output, StartsWith("6541:proxy.dummy-1.living.actuator.lamp-1.command confirmed"));
    EXPECT_EQ(rubicon({"get", name}).output, "on\n") << name;
  }
  EXPECT_EQ(rubicon({"get", "Living room.lamp-1"}).output, "on\n") << "its id still names it";
  EXPECT_EQ(rubicon({"get", "kitchen.Reading lamp"}).code, 8);
  const auto event = rubicon({"watch", "Reading lamp", "--count", "1"});
  EXPECT_THAT(event.output, HasSubstr("actuator.lamp-1.value = on"));
  EXPECT_THAT(rubicon({"get", "Living room.Reading lmap"}).errors,
              HasSubstr("did you mean 'Living room.Reading lamp'"));
}

TEST_F(CalledPoints, AreShownWithThem) {
  const auto described = rubicon({"describe", "living"});
  EXPECT_THAT(described.output, AllOf(HasSubstr("NAME"), HasSubstr("Reading lamp"), HasSubstr("lamp-2")));
  EXPECT_THAT(rubicon({"describe", "kitchen"}).output, Not(HasSubstr("NAME "))) << "no point of it has a name";
  const auto one = rubicon({"describe", "Reading lamp", "--json"});
  const auto points = lines_of(one).at(0)["points"];
  ASSERT_EQ(points.size(), 1U) << one.output << one.errors;
  EXPECT_EQ(points[0]["name"], "Reading lamp");
  EXPECT_EQ(rubicon({"describe", "Living room.light-1", "--json"}).code, 0);
  EXPECT_EQ(in_bash("rubicon get Rea"), "Reading\\ lamp\n");
  EXPECT_THAT(in_bash("rubicon set Living\\ room.R"), HasSubstr("Reading\\ lamp\n"));
}

TEST_F(CalledPoints, AreCountedAndRecorded) {
  const auto rates = rubicon({"top", "Living room.light", "--rounds", "1", "--interval", "300ms", "--json"});
  EXPECT_EQ(rates.code, 0) << rates.errors;
  EXPECT_EQ(rubicon({"top", "Nobody at home.light", "--rounds", "1", "--interval", "100ms"}).code, 8);
  Outcome table;
  for (int i = 0; i < 20 && table.output.find("NAME") == std::string::npos; ++i)
    table = rubicon({"top", "--by", "device", "--rounds", "1", "--interval", "2s"});
  EXPECT_THAT(table.output, HasSubstr("NAME"));
  const auto file = world_->folder.file("lamp.rec");
  const auto recorded = rubicon({"record", file, "Reading lamp", "--for", "3s"});
  EXPECT_EQ(recorded.code, 0) << recorded.errors;
  EXPECT_THAT(recorded.errors, HasSubstr("6541:proxy.dummy-1.living.actuator.lamp-1.** is recorded"));
  EXPECT_THAT(recorded.output, Not(ContainsRegex("(^|[^0-9])0 records")));
}

TEST_F(Called, AForgottenDeviceIsGone) {
  ASSERT_EQ(rubicon({"rename", "right", "Old blind"}).code, 0);
  const auto gone = rubicon({"inbox", "forget", "Old blind"});
  EXPECT_EQ(gone.code, 0) << gone.errors;
  EXPECT_THAT(gone.output, StartsWith("forgot dummy-1.right"));
  EXPECT_EQ(rubicon({"inbox", "forget", "Blnid"}).code, 3);
}

TEST_F(Called, HistoryAsksTheIsland) {
  ASSERT_EQ(rubicon({"watch", "living.light-1", "--count", "3", "--min-interval", "1s"}).code, 0);
  auto csv = rubicon({"history", "Living room.light", "--from", "1h", "--csv"});
  for (int i = 0; i < 200 && csv.output.find(kLight) == csv.output.npos; ++i)  // it writes once a second
    csv = rubicon({"history", "Living room.light", "--from", "1h", "--csv"});
  EXPECT_EQ(csv.code, 0) << csv.errors;
  EXPECT_THAT(csv.output, AllOf(StartsWith("time,key,count,first,minimum,maximum,mean,last\n"), HasSubstr(kLight)));
  EXPECT_THAT(rubicon({"history", "living.light-1"}).output, AllOf(HasSubstr(kLight), HasSubstr("MEAN")));
  const auto json = lines_of(rubicon({"history", "living.*", "--island", "home", "--buckets", "5", "--json"})).at(0);
  ASSERT_EQ(json["series"].size(), 4U) << json;
  for (const auto& one : json["series"]) EXPECT_LE(one.contains("t") ? one["t"].size() : 0U, 5U);
  EXPECT_EQ(rubicon({"history", "Living rom.light"}).code, 8);
  EXPECT_EQ(rubicon({"history", "living.light-1", "--from", "1h", "--to", "2h"}).code, 2);
  EXPECT_EQ(rubicon({"history", world_->folder.file("home.history")}).code, 2) << "a file needs a command";
}

TEST_F(Called, CompletionOffersNamesAsTheShellNeedsThem) {
  EXPECT_EQ(in_bash("rubicon get Liv"), "Living\\ room.\n");
  EXPECT_EQ(in_bash("rubicon get Living\\ room.la"), "Living\\ room.lamp-1\nLiving\\ room.lamp-2\n");
  EXPECT_EQ(in_bash("rubicon get 'Living room.li"), "Living room.light-1\n");
  EXPECT_EQ(in_bash("rubicon get home:Living\\ room.li"), "Living\\ room.light-1\n") << "bash keeps what is before it";
  EXPECT_EQ(in_bash("rubicon describe K"), "Küche/oben\n");
  EXPECT_EQ(in_bash("rubicon describe 6541:K"), "Küche/oben\n");
  EXPECT_EQ(in_bash("rubicon set Living\\ room.l"), "Living\\ room.lamp-1\nLiving\\ room.lamp-2\n") << "no sensor";
  EXPECT_EQ(in_bash("rubicon set 'Living room.lamp-1' o"), "off\non\n");
  EXPECT_EQ(in_bash("rubicon set kitchen.t"), "\n");
  EXPECT_THAT(in_bash("rubicon devices --type temp"), HasSubstr("temperature\n"));
  EXPECT_EQ(in_bash("rubicon get --island ho"), "home\n");
}

TEST(Completion, SplitsALineAsAShellDoes) {
  const auto split = [](const char* line) { return split_line(line).words; };
  using Words = std::vector<std::string>;
  EXPECT_EQ(split("rubicon get "), (Words{"rubicon", "get", ""}));
  EXPECT_EQ(split("rubicon  get\tLiving\\ ro"), (Words{"rubicon", "get", "Living ro"}));
  EXPECT_EQ(split("a 'b c'd \"e \\\" f"), (Words{"a", "b cd", "e \" f"}));
  EXPECT_EQ(split("a '' b"), (Words{"a", "", "b"}));
  EXPECT_TRUE(split_line("a 'b").is_quoted);
  EXPECT_FALSE(split_line("a 'b'").is_quoted);
  EXPECT_FALSE(split_line("a b\\").is_quoted);
}

TEST(Completion, QuotesForBash) {
  EXPECT_EQ(for_bash("Living room.", "Liv", false, true), "Living\\ room.");
  EXPECT_EQ(for_bash("Living room.", "Liv", true, true), "Living room.");
  EXPECT_EQ(for_bash("Tom's $(x).", "", false, true), "Tom\\'s\\ \\$\\(x\\).");
  EXPECT_EQ(for_bash("home:Living room.", "home:Li", false, true), "Living\\ room.") << "bash keeps what is before it";
  EXPECT_EQ(for_bash("home:Living room.", "home:Li", false, false), "home:Living\\ room.");
}

}  // namespace
}  // namespace rubicon::cli
