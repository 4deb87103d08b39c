#include "config/yaml.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace rubicon::config {
namespace {

std::string parse_error_of(std::string_view text) {
  const auto tree = parse_yaml(text, "x.yaml");
  return tree ? "(none)" : tree.error().text;
}

std::string repeated(std::string_view piece, std::size_t bytes) {
  std::string text;
  text.reserve(bytes + piece.size());
  while (text.size() < bytes) text += piece;
  return text;
}

/// Refused or read: never slower than a person waits, whatever machine and sanitizer.
void expect_quick(std::string_view text) {
  const auto start = std::chrono::steady_clock::now();
  const auto tree = parse_yaml(text, "x.yaml");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60)) << text.substr(0, 40);
}

TEST(Yaml, KeepsTextPlacesAndTheOrderOfTheFile) {
  const auto tree = parse_yaml("island: {id: 6541, name: 'on'}\nlist:\n  - 1\n  - off\nnothing:\n", "home.yaml");
  ASSERT_TRUE(tree) << tree.error().text;
  ASSERT_EQ(tree->entries.size(), 3U);
  const auto* id = tree->find("island")->find("id");
  EXPECT_EQ(id->text, "6541");
  EXPECT_FALSE(id->was_quoted);
  EXPECT_EQ(to_string(id->place), "home.yaml:1:14");
  EXPECT_TRUE(tree->find("island")->find("name")->was_quoted);
  EXPECT_EQ(tree->find("list")->items.at(1).text, "off");
  EXPECT_EQ(to_string(tree->find("list")->items.at(1).place), "home.yaml:4:5");
  EXPECT_EQ(tree->find("nothing")->kind, ConfigNode::Kind::kNull);
  EXPECT_EQ(tree->entries[2].first, "nothing");
}

TEST(Yaml, NamesEachKeyThatStandsTwice) {
  const auto text = parse_error_of("a: 1\nb: {c: 1, c: 2}\na: 2\n");
  EXPECT_NE(text.find("x.yaml:2:11: key 'c' is twice"), text.npos) << text;
  EXPECT_NE(text.find("x.yaml:3:1: key 'a' is twice"), text.npos) << text;
}

TEST(Yaml, SaysThatATabIsTheReason) {
  const auto text = parse_error_of("networks:\n\tdummy-1:\n\t\ttype: dummy\n");
  EXPECT_NE(text.find("x.yaml:2:"), text.npos) << text;
  EXPECT_NE(text.find("the indentation has a tab"), text.npos) << text;
}

TEST(Yaml, RefusesAliasesSoThatNoBombUnfolds) {
  std::string bomb = "a0: &a0 [x,x,x,x,x,x,x,x,x,x]\n";
  for (int i = 1; i < 12; ++i) {
    const auto before = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before + "," + before + "," + before + "]\n";
  }
  const auto text = parse_error_of(bomb);
  EXPECT_NE(text.find("x.yaml:2:10: aliases (*name) are not supported"), text.npos) << text;
}

TEST(Yaml, TakesAByteOrderMarkAndLinesOfWindows) {
  const auto tree = parse_yaml("\xef\xbb\xbfisland: {id: 1}\r\nnetworks:\r\n  dummy: {type: dummy}\r\n", "x.yaml");
  ASSERT_TRUE(tree) << tree.error().text;
  EXPECT_EQ(tree->find("networks")->find("dummy")->find("type")->text, "dummy");
  EXPECT_EQ(to_string(tree->find("networks")->find("dummy")->find("type")->place), "x.yaml:3:17");
}

TEST(Yaml, ExpectsOneDocumentThatIsAMap) {
  EXPECT_NE(parse_error_of("a: 1\n---\nb: 2\n").find("more than one document"), std::string::npos);
  EXPECT_NE(parse_error_of("- a\n- b\n").find("expected a map"), std::string::npos);
  EXPECT_NE(parse_error_of("").find("expected a map"), std::string::npos);
  EXPECT_NE(parse_error_of("just text").find("expected a map"), std::string::npos);
  EXPECT_NE(parse_error_of("[a, b]: c\n").find("a key must be one value"), std::string::npos);
}

TEST(Yaml, RefusesMoreValuesThanAConfigurationHas) {
  const auto text = parse_error_of("a: [" + repeated("1,", 2 * kMaxYamlNodes + 10) + "]\n");
  EXPECT_NE(text.find("more than 200000 values"), text.npos) << text.substr(0, 200);
}

TEST(Yaml, RefusesATenMegabyteFileByItsSize) {
  const auto text = parse_error_of(repeated("a", 10'000'000));
  EXPECT_NE(text.find("10000000 bytes, a configuration has at most"), text.npos) << text.substr(0, 200);
}

TEST(Yaml, SurvivesNestingThatWouldExhaustTheStack) {
  EXPECT_NE(parse_error_of(repeated("[", 1'000'000)), "(none)");
  EXPECT_NE(parse_error_of("a: " + repeated("{a: ", 1'000'000)), "(none)");
  EXPECT_NE(parse_error_of(repeated("- ", 1'000'000)), "(none)");
  EXPECT_NE(parse_error_of(repeated("? ", 1'000'000)), "(none)");
  std::string staircase;
  for (int i = 0; i < 1000; ++i) staircase += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_NE(parse_error_of(staircase), "(none)");
}

TEST(Yaml, SurvivesHostileText) {
  for (const std::string_view text : {"\x01\x02",   "a: \"\\xzz\"", "a: 'open",     "%YAML 9.9\n---\na: 1",
                                      "a: !!int x", "&a",           "a: *",         "{",
                                      "}",          "a: b: c",      "? a\n: b\n? ", "a: |\n",
                                      "a: >9\n x",  "\xff\xfe\x00", "\xc3\x28: 1",  "@",
                                      "`",          "a: @b",        "- : -",        "!",
                                      "!<",         "a: &"}) {
    const auto tree = parse_yaml(text, "x.yaml");
    EXPECT_TRUE(tree || tree.error().text.find("x.yaml") != std::string::npos) << text;
  }
  EXPECT_NE(parse_error_of(std::string_view("a\0b: \0\0", 7)), "");
}

TEST(Yaml, ReadsOrRefusesLargeHostileFilesInBoundedTime) {
  constexpr std::size_t kMegabyte = 1024 * 1024;
  expect_quick("a: " + repeated("x ", kMegabyte));
  expect_quick("a: |\n" + repeated("\n", kMegabyte));
  expect_quick("a: >\n" + repeated(" x\n\n", kMegabyte));
  expect_quick("a: \"" + repeated("\\\n", kMegabyte));
  expect_quick("a: [" + repeated("&a !b ", kMegabyte));
  expect_quick(repeated("a: ", kMegabyte));
  expect_quick(repeated("#", kMegabyte));
  std::string keys;
  for (int i = 0; keys.size() < kMegabyte; ++i) keys += "k" + std::to_string(i) + ": 1\n";
  expect_quick(keys);
}

TEST(Yaml, AValueOfTheCommandLineIsPlacedThere) {
  const auto scalar = parse_yaml_value("20ms", "--set 'a=20ms'");
  ASSERT_TRUE(scalar);
  EXPECT_EQ(scalar->text, "20ms");
  const auto map = parse_yaml_value("{a: 1, b: [x]}", "--set 'm=...'");
  ASSERT_TRUE(map);
  EXPECT_EQ(to_string(map->find("b")->items.at(0).place), "--set 'm=...'");
  EXPECT_EQ(parse_yaml_value("", "--set 'a='")->kind, ConfigNode::Kind::kNull);
  EXPECT_NE(parse_yaml_value("{", "--set 'a={'").error().text.find("--set 'a={'"), std::string::npos);
}

}  // namespace
}  // namespace rubicon::config
