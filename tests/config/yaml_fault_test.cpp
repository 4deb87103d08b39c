#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/yaml.h"

namespace rubicon::config {
namespace {

struct Broken {
  std::string_view text, error;  ///< the error's beginning, behind the file's name
};

std::string error_of(std::string_view text) {
  const auto tree = parse_yaml(text, "x.yaml");
  return tree ? "(none)" : tree.error().text;
}

const std::vector<Broken> kBroken{
    // Brackets: where they open.
    {"a: {b: 1\nc: 2\n", "1:4: the '{' that opens here is never closed"},
    {"networks:\n  d1: {type: dummy\n  d2: {type: dummy}\n", "2:7: the '{' that opens here is never closed"},
    {"a: [1, 2\nb: 3\n", "1:4: the '[' that opens here is never closed"},
    {"a: {b: {c: 1}\nd: {e: 1}\n", "1:4: the '{' that opens here is never closed"},
    {"a: {b: [1, 2}\n", "1:8: the '[' that opens here meets '}' in line 1, column 13, expected ']'"},
    {"a: [b: {c]\n", "1:8: the '{' that opens here meets ']' in line 1, column 10, expected '}'"},
    {"a: ]\n", "1:4: this ']' closes nothing"},
    {"a: {b: 1}}\n", "1:10: this '}' closes nothing"},
    {"a: 1 # {\nb: }\n", "2:4: this '}' closes nothing"},
    {"a: {b: c: d}\n", "1:9: expected ',' or '}' here"},
    // Quotes: where they open.
    {"a: 'open\nb: 2\n", "1:4: the ' that opens here is never closed"},
    {"a: 1\nb: \"open\n", "2:4: the \" that opens here is never closed"},
    {"a: 'open\nb: 'two'\n", "1:4: the ' that opens here closes only in line 2"},
    {"a: {b: \"x}\nc: \"y\"\n", "1:8: the \" that opens here closes only in line 2"},
    {"a: # x\n  b: {c: 'd}\n  e: 1\n", "2:10: the ' that opens here is never closed"},
    {"a: \"x\" y\n", "1:8: text follows the closing \"; within the quotes write \\\" for \""},
    {"a: 'it's'\n", "1:8: text follows the closing '; within the quotes write '' for '"},
    {"a: \"\\q\"\n", "1:7: no escape begins so; write \\\\ for a backslash"},
    {"a: \"\\xzz\"\n", "1:9: expected hex digits behind \\x"},
    // Colons and indentation.
    {"name: Kitchen: left\n", "1:14: a second ':' in one value; put a text that contains ': ' in quotes"},
    {"island: {id: 1}\nnetworks\n  dummy: {type: dummy}\n", "2:9: a ':' is missing behind 'networks'"},
    {"a: 1\nb\nc: 2\n", "2:2: a ':' is missing behind 'b'"},
    {"a:b\nc: 1\n", "1:2: a blank must follow the ':' of a key"},
    {"a:\n  b: 1\n    c: 2\n", "3:5: this line is deeper than the one above it, 'b: 1', which has its value"},
    {"a: 1\n b: 2\n", "2:2: this line is deeper than the one above it, 'a: 1', which has its value"},
    {"a:\n    b: 1\n  c: 2\n", "3:3: this line begins with 2 blanks, expected 0 or 4 as the lines above"},
    {"b: 1\n- a\n", "2:1: a list item ('- ') cannot stand among the keys of a map"},
    {"a: - b\n", "1:4: a list item ('- ') cannot stand here; begin the list on a line of its own"},
    {"a:\n\tb: 1\n", "2:1: the indentation has a tab; YAML accepts only blanks there"},
    {"a:\n  b: 1\n\tc: 2\n", "3:1: the indentation has a tab"},
    // Characters that begin something else.
    {"a: @b\n", "1:4: a value cannot begin with this character; put it in quotes"},
    {"a: `b\n", "1:4: a value cannot begin with this character"},
    {"a: %b\n", "1:4: a value cannot begin with this character"},
    {"a: , b\n", "1:4: a value cannot begin or go on here; put it in quotes"},
    {"a: *x\n", "1:4: aliases (*name) are not supported"},
    {"a: !<x\n", "1:7: '!' begins a tag; put a text that begins with it in quotes"},
    {"a: |x\n  y\n", "1:5: only a line end can stand behind | and >"},
    {"%YAML 9\n---\na: 1\n", "1:1: expected %YAML 1.2 or no such line"},
    // Bytes.
    {"island: {id: 1}\nname: K\xfc"
     "che\n",
     "2:8: byte 0xfc is not UTF-8; save the file as UTF-8"},
    {"# Gr\xfc\xdf"
     "e\nisland: {id: 1}\n",
     "1:5: byte 0xfc is not UTF-8"},
    {"\xff\xfei\0s\0", "1:1: the file is UTF-16, expected UTF-8"},
    {"a: 1\nb: x\x01y\n", "2:5: control character 0x01, expected text"},
};

TEST(YamlFaults, AreToldInOurWordsWhereTheAuthorLooksForThem) {
  for (const auto& [text, error] : kBroken)
    EXPECT_THAT(error_of(text), testing::StartsWith("x.yaml:" + std::string(error))) << text;
}

TEST(YamlFaults, NeverShowTheParsersOwnWords) {
  for (const auto& [text, error] : kBroken) {
    for (const auto* words : {"not found", "illegal", "unknown token", "this is no YAML ("})
      EXPECT_THAT(error_of(text), testing::Not(testing::HasSubstr(words))) << text;
  }
}

TEST(YamlFaults, WhatOnlyLooksLikeOneIsTaken) {
  for (const std::string_view text :
       {"a: don't\nb: it's\n", "a: |\n  'open\n  {[\n\n    \"\nb: 1\n", "# it's {\na: 1\n", "a: x # 'y\nb: 2\n",
        "a: b}c]\n", "a: 'it''s'\n", "a: \"\\\"\"\n", "a: [\"x\", 'y']\n", "a: {\"b\": 1}\n", "'a': 1\n",
        "a: >-\n  folded '\nb: 2\n", "- : 1\n"}) {
    EXPECT_THAT(error_of(text), testing::AnyOf("(none)", testing::HasSubstr("expected a map"))) << text;
  }
  EXPECT_EQ(error_of("a: |\n  'open\n  {[\n\n    \"\nb: 1\n"), "(none)");
}

TEST(YamlFaults, AQuoteWithinATextWithoutQuotesOrABlockTextIsNone) {
  for (const std::string_view text :
       {"name: the lamp\n  'tis here\n", "name: the lamp\n\n\n  \"tis here\n", "a: &x |\n  \"quoted\n",
        "a: !!str |\n  'x\n", "a: !!str &x >-\n  'x\n", "a:\n  |\n  'x\n", "a:\n  b: one\n    'two\nc: 3\n",
        "a:\n- one\n  'two\n- three\n", "- a: one\n    'two\n  b: 3\n", "a:\n    one\n  'two\n",
        "a: [one\n  'two, three]\n", "a: {b: one\n  'two}\n", "'a': one\n 'two\n", "%YAML 1.2\n---\na: b\n...\n",
        "--- # x\na: 'b'\n", "a: &x 'b'\nc: !!str 'd'\n", "? a\n: 'b'\n", "a: -'b\n", "- - a\n  - 'b'\n"}) {
    EXPECT_THAT(error_of(text), testing::AnyOf("(none)", testing::HasSubstr("expected a map"))) << text;
  }
}

TEST(YamlFaults, AnOpenQuoteBehindSuchATextIsFound) {
  const std::vector<Broken> broken{
      {"a: the lamp\n  'tis here\nb: 'open\n", "3:4: the ' that opens here is never closed"},
      {"a: &x |\n  'quoted\nb: \"open\nc: 1\n", "3:4: the \" that opens here is never closed"},
      {"a: &x 'open\nb: 1\n", "1:7: the ' that opens here is never closed"},
      {"a: b\n'c: d\n", "2:1: the ' that opens here is never closed"},
      {"a: the lamp\n  'tis here\nb: ]\n", "3:4: this ']' closes nothing"},
  };
  for (const auto& [text, error] : broken)
    EXPECT_THAT(error_of(text), testing::StartsWith("x.yaml:" + std::string(error))) << text;
}

TEST(YamlFaults, AWordOfTheCommandLineInAnotherEncodingIsRefused) {
  const auto value = parse_yaml_value(
      "K\xfc"
      "che",
      "--set 'island.name=...'");
  ASSERT_FALSE(value);
  EXPECT_THAT(value.error().text, testing::HasSubstr("byte 0xfc is not UTF-8"));
}

}  // namespace
}  // namespace rubicon::config
