#include "base/config_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "support/config_text.h"

namespace rubicon::base {
namespace {

using namespace std::chrono_literals;

/// Each node gets a line of its own, counted through the tree as an author would write it.
void place(ConfigNode& node, int& line, int column) {
  node.place = {"home.yaml", line, column};
  for (auto& [key, entry] : node.entries) place(entry, ++line, column + 2);
  for (auto& item : node.items) place(item, ++line, column + 2);
}

/// A configuration written as JSON: the map stands in line 1, what is in it below, in the order written.
class ConfigReaderTest : public testing::Test {
 protected:
  ConfigReader& read(std::string_view json) {
    node_ = support::config_of(json);
    int line = 1;
    place(node_, line, 1);
    reader_ = std::make_unique<ConfigReader>(node_, "dev", errors_);
    return *reader_;
  }

  ConfigErrors errors_;

 private:
  ConfigNode node_;
  std::unique_ptr<ConfigReader> reader_;
};

TEST_F(ConfigReaderTest, AnAbsentKeyGivesTheDefault) {
  auto& in = read("{}");
  EXPECT_FALSE(in.has("a"));
  EXPECT_EQ(in.text("a", "x"), "x");
  EXPECT_EQ(in.choice("a", "x", {"x", "y"}), "x");
  EXPECT_TRUE(in.boolean("a", true));
  EXPECT_EQ(in.integer("a", 5), 5);
  EXPECT_EQ(in.real("a", 1.5), 1.5);
  EXPECT_EQ(in.duration("a", 5s), 5s);
  EXPECT_EQ(in.duration_or_never("a", std::nullopt), std::nullopt);
  EXPECT_EQ(in.node("a"), nullptr);
  EXPECT_TRUE(in.map("a").keys().empty());
  EXPECT_TRUE(in.maps("a").empty());
  EXPECT_TRUE(in.texts("a").empty());
  EXPECT_TRUE(in.list("a").empty());
  EXPECT_TRUE(errors_.empty()) << errors_.text();
}

TEST_F(ConfigReaderTest, ReadsText) {
  EXPECT_EQ(read(R"({"name": "home"})").text("name", ""), "home");
  EXPECT_EQ(read(R"({"name": [1]})").text("name", "x"), "x");
  EXPECT_EQ(read(R"({"name": null})").text("name", "x"), "x");
  EXPECT_EQ(read(R"({"name": {}})").text("name", "x"), "x");
  EXPECT_EQ(errors_.lines(), (std::vector<std::string>{"home.yaml:2:3: dev.name: is a list, expected one value",
                                                       "home.yaml:2:3: dev.name: is nothing, expected one value",
                                                       "home.yaml:2:3: dev.name: is a map, expected one value"}));
}

TEST_F(ConfigReaderTest, SaysThatARequiredTextIsMissing) {
  EXPECT_EQ(read(R"({"name": "home"})").required_text("name"), "home");
  EXPECT_TRUE(errors_.empty());
  EXPECT_EQ(read("{}").required_text("name"), "");
  EXPECT_EQ(errors_.text(), "home.yaml:1:1: dev: 'name' is missing");
}

TEST_F(ConfigReaderTest, AChoiceIsOneOfItsWords) {
  EXPECT_EQ(read(R"({"mode": "ask"})").choice("mode", "auto", {"auto", "ask"}), "ask");
  EXPECT_TRUE(errors_.empty());
  EXPECT_EQ(read(R"({"mode": "Ask"})").choice("mode", "auto", {"auto", "ask"}), "auto");
  EXPECT_EQ(errors_.text(), "home.yaml:2:3: dev.mode: is 'Ask'; did you mean 'ask'? expected one of: auto, ask");
}

TEST_F(ConfigReaderTest, ABooleanIsYesOrNo) {
  for (const auto* yes : {"true", "yes", "on"}) {
    EXPECT_TRUE(read(std::string(R"({"loop": ")") + yes + "\"}").boolean("loop", false)) << yes;
  }
  for (const auto* no : {"false", "no", "off"}) {
    EXPECT_FALSE(read(std::string(R"({"loop": ")") + no + "\"}").boolean("loop", true)) << no;
  }
  EXPECT_TRUE(errors_.empty());
  EXPECT_TRUE(read(R"({"loop": "1"})").boolean("loop", true));
  EXPECT_EQ(errors_.text(), "home.yaml:2:3: dev.loop: is '1', expected yes or no");
}

TEST_F(ConfigReaderTest, AnIntegerKeepsToItsRange) {
  EXPECT_EQ(read(R"({"id": 6541})").integer("id", 0, 1, 65532), 6541);
  EXPECT_EQ(read(R"({"id": "+7"})").integer("id", 0), 7);
  EXPECT_EQ(read(R"({"id": -7})").integer("id", 0), -7);
  EXPECT_TRUE(errors_.empty());
  EXPECT_EQ(read(R"({"id": 65533})").integer("id", 5, 1, 65532), 5);
  EXPECT_EQ(errors_.text(), "home.yaml:2:3: dev.id: is '65533', expected a whole number from 1 to 65532");
}

TEST_F(ConfigReaderTest, WhatIsNoIntegerIsRefused) {
  const std::string_view wrong[] = {"1.5", "", "0x10", "1 ", "+-7", "--7", "+", "seven", "99999999999999999999"};
  for (const auto text : wrong) {
    EXPECT_EQ(read(nlohmann::json{{"id", text}}.dump()).integer("id", 5, 0, 9), 5);
    EXPECT_EQ(errors_.lines().back(),
              "home.yaml:2:3: dev.id: is '" + std::string(text) + "', expected a whole number from 0 to 9");
  }
  EXPECT_EQ(errors_.lines().size(), std::size(wrong));
}

TEST_F(ConfigReaderTest, ANumberKeepsToItsRange) {
  EXPECT_EQ(read(R"({"speed": 2.5})").real("speed", 1, 0, 10), 2.5);
  EXPECT_EQ(read(R"({"speed": "1e1"})").real("speed", 1, 0, 10), 10);
  EXPECT_TRUE(errors_.empty());
  const std::string_view wrong[] = {"10.5", "-1", "nan", "inf", "2,5", "", "1e999", "+-1", "fast"};
  for (const auto text : wrong) {
    EXPECT_EQ(read(nlohmann::json{{"speed", text}}.dump()).real("speed", 1, 0, 10), 1);
    EXPECT_EQ(errors_.lines().back(),
              "home.yaml:2:3: dev.speed: is '" + std::string(text) + "', expected a number from 0 to 10");
  }
  EXPECT_EQ(errors_.lines().size(), std::size(wrong));
}

TEST_F(ConfigReaderTest, ADurationHasAUnit) {
  EXPECT_EQ(read(R"({"silence": "60s"})").duration("silence", 1s), 60s);
  EXPECT_TRUE(errors_.empty());
  EXPECT_EQ(read(R"({"silence": 60})").duration("silence", 1s), 1s);
  EXPECT_EQ(errors_.text(), "home.yaml:2:3: dev.silence: is '60', expected a duration such as 250ms, 5s, 2min, 1h");
  EXPECT_EQ(read(R"({"silence": "never"})").duration("silence", 1s), 1s);
  EXPECT_EQ(errors_.lines().size(), 2U);
}

TEST_F(ConfigReaderTest, ASizeHasAUnit) {
  const std::pair<std::string_view, std::uint64_t> good[] = {
      {"512B", 512},          {"100kB", 100'000},       {"64KiB", 65'536},
      {"100MB", 100'000'000}, {"1.5GB", 1'500'000'000}, {"2TiB", 2ULL << 40}};
  for (const auto& [text, bytes] : good) EXPECT_EQ(parse_size(text), bytes) << text;
  for (const auto* text : {"", "100", "MB", "1 MB", "-1MB", "1mb", "1e3MB", "99999999TB", "0x10B"})
    EXPECT_FALSE(parse_size(text)) << text;
  EXPECT_EQ(read(R"({"size": "2MB"})").size("size", 7), 2'000'000u);
  EXPECT_EQ(read(R"({"size": "2"})").size("size", 7), 7u);
  EXPECT_EQ(errors_.text(), "home.yaml:2:3: dev.size: is '2', expected a size such as 500kB, 64KiB, 100MB, 1GB");
  EXPECT_EQ(read(R"({"size": "1kB"})").size("size", 7, 65'536, 1'000'000'000), 7u);
  EXPECT_THAT(errors_.text(), testing::HasSubstr("is '1kB', expected from 64KiB to 1GB"));
}

TEST_F(ConfigReaderTest, NeverIsADurationWhereItIsAllowed) {
  EXPECT_EQ(read(R"({"silence": "never"})").duration_or_never("silence", 1s), std::nullopt);
  EXPECT_EQ(read(R"({"silence": "2min"})").duration_or_never("silence", std::nullopt), Duration(2min));
  EXPECT_TRUE(errors_.empty());
  EXPECT_EQ(read(R"({"silence": "Never"})").duration_or_never("silence", 1s), Duration(1s));
  EXPECT_EQ(errors_.text(),
            "home.yaml:2:3: dev.silence: is 'Never', expected a duration such as 250ms, 5s, 2min, 1h, or never");
}

TEST_F(ConfigReaderTest, ReadsNestedMaps) {
  auto& in = read(R"({"limits": {"queue": "many"}, "island": 5})");
  auto limits = in.map("limits");
  EXPECT_EQ(limits.path(), "dev.limits");
  EXPECT_EQ(limits.integer("queue", 10, 0, 99), 10);
  EXPECT_TRUE(in.map("island").keys().empty());
  EXPECT_EQ(errors_.lines(), (std::vector<std::string>{
                                 "home.yaml:3:5: dev.limits.queue: is 'many', expected a whole number from 0 to 99",
                                 "home.yaml:4:3: dev.island: is a value, expected a map"}));
}

TEST_F(ConfigReaderTest, ReadsAMapOfMaps) {
  auto readers = read(R"({"networks": {"wsn-1": {"type": "wsn"}, "knx": 5}})").maps("networks");
  ASSERT_EQ(readers.size(), 2U);
  EXPECT_EQ(readers[0].first, "wsn-1");
  EXPECT_EQ(readers[0].second.text("type", ""), "wsn");
  EXPECT_EQ(readers[1].first, "knx");
  EXPECT_EQ(errors_.text(), "home.yaml:5:5: dev.networks.knx: is a value, expected a map");
}

TEST_F(ConfigReaderTest, ReadsAListOfValues) {
  EXPECT_EQ(read(R"({"files": ["a", "b"]})").texts("files"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(read(R"({"files": "a"})").texts("files"), (std::vector<std::string>{"a"}));
  EXPECT_TRUE(errors_.empty());
  EXPECT_EQ(read(R"({"files": ["a", ["b"]]})").texts("files"), (std::vector<std::string>{"a"}));
  EXPECT_TRUE(read(R"({"files": {"a": 1}})").texts("files").empty());
  EXPECT_EQ(errors_.lines(),
            (std::vector<std::string>{"home.yaml:4:5: dev.files: contains a list, expected only values",
                                      "home.yaml:2:3: dev.files: is a map, expected a list of values"}));
}

TEST_F(ConfigReaderTest, ReadsAListOfMaps) {
  auto readers = read(R"({"waves": [{"form": "sine"}, "flat"]})").list("waves");
  ASSERT_EQ(readers.size(), 2U);
  EXPECT_EQ(readers[0].path(), "dev.waves[0]");
  EXPECT_EQ(readers[0].text("form", ""), "sine");
  EXPECT_TRUE(read(R"({"waves": "sine"})").list("waves").empty());
  EXPECT_EQ(errors_.lines(), (std::vector<std::string>{"home.yaml:5:5: dev.waves[1]: is a value, expected a map",
                                                       "home.yaml:2:3: dev.waves: is a value, expected a list"}));
}

TEST_F(ConfigReaderTest, ReportsKeysThatNobodyAskedFor) {
  auto& in = read(R"({"host": "a", "prot": 5, "extra": {"deep": 1}})");
  EXPECT_EQ(in.keys(), (std::vector<std::string>{"host", "prot", "extra"}));
  EXPECT_EQ(in.text("host", ""), "a");
  EXPECT_EQ(in.integer("port", 80), 80);
  in.finish();
  EXPECT_EQ(errors_.lines(),
            (std::vector<std::string>{"home.yaml:3:3: dev: unknown key 'prot'; did you mean 'port'? known: host, port",
                                      "home.yaml:4:3: dev: unknown key 'extra', known: host, port"}));
}

TEST_F(ConfigReaderTest, AKeyThatAnotherReaderTakesIsKnown) {
  auto& in = read(R"({"silnce": "5s", "rate": "1s"})");
  in.also_known(std::array<std::string_view, 2>{"silence", "rate"});
  in.finish();
  EXPECT_EQ(errors_.lines(),
            (std::vector<std::string>{
                "home.yaml:2:3: dev: unknown key 'silnce'; did you mean 'silence'? known: rate, silence"}));
}

TEST_F(ConfigReaderTest, TakesErrorsOfItsUser) {
  auto& in = read(R"({"host": "a"})");
  in.error("host", "is not reachable by name");
  in.error("", "has no networks");
  EXPECT_EQ(errors_.text(), "home.yaml:2:3: dev.host: is not reachable by name\nhome.yaml:1:1: dev: has no networks");
}

TEST_F(ConfigReaderTest, RefusesWhatIsNoMap) {
  auto& in = read("[1]");
  EXPECT_EQ(in.text("a", "x"), "x");
  EXPECT_EQ(errors_.text(), "home.yaml:1:1: dev: is a list, expected a map");
}

TEST_F(ConfigReaderTest, TakesNothingForAnEmptyMap) {
  auto& in = read("null");
  in.finish();
  EXPECT_TRUE(errors_.empty());
}

TEST_F(ConfigReaderTest, ShowsForeignTextShortAndPrintable) {
  read(nlohmann::json{{"mode", "\n" + std::string(100, 'x')}}.dump()).choice("mode", "a", {"a"});
  EXPECT_EQ(errors_.text(), "home.yaml:2:3: dev.mode: is '?" + std::string(59, 'x') + "...', expected one of: a");
}

TEST(PackedConfig, IsTheTreeWithoutPlaces) {
  const auto json = R"({"a": [1, [], {}, null], "b": {"c": "", "long": ")" + std::string(300, 'x') + R"("}, "": "y"})";
  auto node = support::config_of(std::string_view(json));
  node.find("b")->find("c")->was_quoted = true;
  int line = 1;
  place(node, line, 1);
  const auto text = packed(node);
  const auto again = unpacked(text);
  EXPECT_TRUE(differences(node, again, 1).empty());
  EXPECT_EQ(packed(again), text);
  EXPECT_TRUE(again.find("b")->find("c")->was_quoted);
  EXPECT_EQ(to_string(again.find("b")->place), "");
  EXPECT_LT(text.size(), 350U) << "of 330 letters";
}

TEST(ConfigPlace, IsTheFileAloneWhenThereIsNoLine) {
  EXPECT_EQ(to_string(ConfigPlace{"--set", 0, 0}), "--set");
  EXPECT_EQ(to_string(ConfigPlace{"home.yaml", 3, 7}), "home.yaml:3:7");
}

TEST(ConfigErrors, LeaveOutWhatIsNotKnown) {
  ConfigErrors errors;
  errors.add({}, "", "no island");
  EXPECT_EQ(errors.text(), "no island");
}

TEST(Duration, HasANumberAndAUnit) {
  EXPECT_EQ(parse_duration("250us"), Duration(250us));
  EXPECT_EQ(parse_duration("250ms"), Duration(250ms));
  EXPECT_EQ(parse_duration("5s"), Duration(5s));
  EXPECT_EQ(parse_duration("1.5h"), Duration(90min));
  EXPECT_EQ(parse_duration("2min"), Duration(2min));
  EXPECT_EQ(parse_duration("1d"), Duration(24h));
  EXPECT_EQ(parse_duration("0s"), Duration(0));
}

TEST(Duration, IsRefusedWithoutEither) {
  for (const auto* text : {"", "5", "s", "5 s", "-5s", "+5s", "1e3s", "5S", "5sec", "5s ", "..s", "1.2.3s", "infs",
                           "never", "5m", "99999999999d"}) {
    EXPECT_EQ(parse_duration(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace rubicon::base
