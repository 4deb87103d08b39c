#include "client/target_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// An island with a lamp and two motes of one name, and a program with tuples of its own.
class Searches : public testing::Test {
 protected:
  Searches() {
    EXPECT_TRUE(island_.describe(R"({"name":"home","prefix":"proxy"})"));
    device("hall.1", R"({"name":"Living room","actuators":["lamp-1"],"sensors":["light-1"],"properties":["rate"]})");
    for (const auto* id : {"wsn.8", "wsn.9"}) device(id, R"({"name":"Mote","sensors":["temperature-1"]})");
    for (const auto* key : {"proxy.hall.1.actuator.lamp-1.command", "proxy.hall.1.actuator.lamp-1.value",
                            "proxy.hall.1.sensor.light-1.value", "proxy.wsn.8.sensor.temperature-1.value",
                            "proxy.wsn.9.sensor.temperature-1.value", "proxy.island"})
      EXPECT_TRUE(island_.set(key, "1"));
    EXPECT_TRUE(island_.set("proxy.overview", R"({"names":{"hall.1.actuator.lamp-1":"Reading lamp No. 2"}})"));
    EXPECT_TRUE(program_.set("robot.goal", "kitchen"));
    time_.run_ready();
  }

  void device(const std::string& id, const char* description) {
    EXPECT_TRUE(island_.set("proxy." + id + ".description", description));
  }

  /// Keys that were found, or the error.
  std::vector<std::string> found(const std::string& text, const std::string& last = "value") {
    std::vector<std::string> keys;
    TargetSearch search(
        islands_in(program_), text, last,
        [this](const Pattern& pattern, const TuplesCall& call) {
          ++reads_;
          std::vector<Tuple> tuples;
          for (const auto* space : {&island_, &program_})
            space->list({space->self(), pattern.key}, [&](const tuples::TupleView& tuple) {
              if (pattern.matches(tuple.owner, tuple.key)) tuples.emplace_back(tuple);
            });
          call(std::move(tuples));
        },
        [&](const Result<Findings>& findings) {
          const auto one = findings ? the_one(*findings, text) : fail(findings.error());
          keys = {one ? to_string(*one) : one.error().text};
        });
    search.start();
    return keys;
  }

  base::VirtualScheduler time_;
  tuples::MemoryEcology ecology_{time_};
  std::unique_ptr<tuples::Link> island_link_ = ecology_.join(OwnerId(6541)).value(),
                                program_link_ = ecology_.join(OwnerId(70000)).value();
  TupleSpace island_{OwnerId(6541), time_, *island_link_}, program_{OwnerId(70000), time_, *program_link_};
  std::size_t reads_ = 0;
};

TEST_F(Searches, KeysGoBeforeShortNamesAndThoseBeforeNamesOfPeople) {
  const std::vector<std::pair<const char*, const char*>> table{
      {"6541:proxy.island", "6541:proxy.island"},
      {"proxy.island", "6541:proxy.island"},
      {"robot.goal", "70000:robot.goal"},
      {"1.light-1", "6541:proxy.hall.1.sensor.light-1.value"},
      {"hall.1.light-1", "6541:proxy.hall.1.sensor.light-1.value"},
      {"6541:1.light-1", "6541:proxy.hall.1.sensor.light-1.value"},
      {"home:1.light-1", "6541:proxy.hall.1.sensor.light-1.value"},
      {"proxy.hall.1.sensor.light-1", "6541:proxy.hall.1.sensor.light-1.value"},
      {"Living room.light", "6541:proxy.hall.1.sensor.light-1.value"},
      {"home:living room.LIGHT-1", "6541:proxy.hall.1.sensor.light-1.value"},
      {"Living room.Reading lamp No. 2", "6541:proxy.hall.1.actuator.lamp-1.value"},
      {"Reading lamp No. 2", "6541:proxy.hall.1.actuator.lamp-1.value"},
      {"reading LAMP no. 2", "6541:proxy.hall.1.actuator.lamp-1.value"},
      {"Living room.*", "6541:proxy.hall.1.*.*.value"},
  };
  for (const auto& [text, key] : table) EXPECT_THAT(found(text), ElementsAre(key)) << text;
}

TEST_F(Searches, AKeyIsFoundWithTheFirstRead) {
  found("6541:proxy.island");
  EXPECT_EQ(reads_, 1U);
}

TEST_F(Searches, WhatIsToBeSetHasToTakeCommands) {
  EXPECT_THAT(found("Reading lamp No. 2", "command"), ElementsAre("6541:proxy.hall.1.actuator.lamp-1.command"));
  EXPECT_THAT(found("Living room.light", "command"), ElementsAre("'Living room.light' can only be read"));
  EXPECT_THAT(found("Living room.rate", "command"), ElementsAre(HasSubstr("can only be read")));
  ASSERT_TRUE(island_.set("proxy.hall.1.property.rate.command", "1"));
  EXPECT_THAT(found("Living room.rate", "command"), ElementsAre("6541:proxy.hall.1.property.rate.command"));
}

TEST_F(Searches, SeveralAreListedAndOfNoneThereIsAHint) {
  EXPECT_THAT(found("Mote.temperature"),
              ElementsAre("'Mote.temperature' is ambiguous; name one of 6541:proxy.wsn.8.sensor.temperature-1.value, "
                          "6541:proxy.wsn.9.sensor.temperature-1.value"));
  EXPECT_THAT(found("Livin room.light"),
              ElementsAre("nothing is called 'Livin room.light'; did you mean 'Living room.light'?"));
  EXPECT_THAT(found("Nobody"), ElementsAre("nothing is called 'Nobody'"));
  EXPECT_THAT(found("a.*b"), ElementsAre(HasSubstr("is a pattern")));
}

TEST_F(Searches, AtMostTenCandidatesAreListed) {
  for (int i = 10; i < 40; ++i) device("wsn." + std::to_string(i), R"({"name":"Mote","sensors":["temperature-1"]})");
  EXPECT_THAT(found("Mote.temperature").at(0), testing::EndsWith("wsn.17.sensor.temperature-1.value, and 22 more"));
}

TEST_F(Searches, OnlyWhatMayBeANameIsLookedFor) {
  const std::vector<std::tuple<const char*, bool, bool>> table{
      // text, is a name, is a name among patterns
      {"6541:proxy.island", false, false},
      {"6541:proxy.hall.1.sensor.light-1.value", false, false},
      {"6541:proxy.hall.1.sensor.light-1", true, true},
      {"6541:1.light-1", true, true},
      {"6541:Living room.light", true, true},
      {"6541:GATEWAY", false, false},
      {"70000:robot.goal", false, false},
      {"9:robot.goal", false, false},
      {"0:note", false, false},
      {"proxy.hall.1.sensor.light-1.value", true, false},
      {"robot.goal", true, true},
      {"*:robot.goal", true, false},
      {"Living room.light", true, true},
      {"Living room.*", false, true},
      {"proxy.*", false, false},
      {"6541:proxy.**", false, false},
      {"a..b", false, false},
      {"", false, false},
  };
  for (const auto& [text, is_one, among_patterns] : table) {
    EXPECT_EQ(is_name(program_, text), is_one) << text;
    EXPECT_EQ(is_name_among_patterns(program_, text), among_patterns) << text;
  }
}

}  // namespace
}  // namespace rubicon::client
