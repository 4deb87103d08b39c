#include "model/point.h"

#include <gtest/gtest.h>

namespace rubicon::model {
namespace {

const std::vector<Word> kModes{{0, "auto"}, {1, "heat"}, {6, "off"}, {13, "economic heat/cool"}};
const std::vector<Word> kBits{{0, "fault"}, {2, "in alarm"}, {3, "overridden"}};

Result<Value> given(std::string_view type, const std::vector<Word>& words, std::string_view text) {
  static const TypeCatalogue types;
  return parse_words(*types.find(type), words, text);
}

std::string why_not(std::string_view type, const std::vector<Word>& words, std::string_view text) {
  const auto value = given(type, words, text);
  return value ? "taken as " + to_text(*value) : value.error().text;
}

TEST(Words, AnEnumerationTakesItsWordsInAnySpellingAndTheirNumbers) {
  for (const auto* text : {"heat", "Heat", " heat", "1", "reserved (1)"}) {
    EXPECT_EQ(given("enumerationOutput", kModes, text), Value(std::string("heat"))) << text;
  }
  EXPECT_EQ(given("enumerationOutput", kModes, "Economic-heat cool"), Value(std::string("economic heat/cool")));
}

TEST(Words, ANumberWithoutAWordStaysANumber) {
  EXPECT_EQ(given("enumerationOutput", kModes, "7"), Value(std::int64_t{7}));
  EXPECT_EQ(given("enumerationOutput", kModes, "reserved (7)"), Value(std::int64_t{7}));
}

TEST(Words, WhatIsNoWordIsRefusedWithThoseThatThereAre) {
  EXPECT_EQ(why_not("enumerationOutput", kModes, "heet"),
            "enumerationOutput: 'heet' is not one of auto, heat, off, economic heat/cool, or a number");
  EXPECT_EQ(why_not("enumerationOutput", kModes, "-1").substr(0, 30), "enumerationOutput: '-1' is not");
  EXPECT_EQ(why_not("enumerationOutput", kModes, "").substr(0, 28), "enumerationOutput: '' is not");
}

TEST(Words, AWordThatCouldBeTwoIsNone) {
  EXPECT_EQ(value_of_word(std::vector<Word>{{1, "stage A"}, {2, "stage-A"}}, "stageA"), std::nullopt);
  EXPECT_EQ(value_of_word(std::vector<Word>{{1, "stage A"}, {2, "stage-A"}}, "stage-A"), 2U);
}

TEST(Words, EveryFormOfASetMeansTheSame) {
  const auto full = R"({"raw":5,"fault":true,"in alarm":true,"overridden":false})";
  for (const auto* text : {R"({"fault": true, "in alarm": true})", R"(["fault", "in-alarm"])", "5", R"({"raw": 5})",
                           R"({"raw": 13, "overridden": false})", R"({"Fault": true, "in alarm": true})"}) {
    const auto value = given("bitsetOutput", kBits, text);
    ASSERT_TRUE(value) << text << ": " << value.error().text;
    EXPECT_EQ(to_text(*value), full) << text;
  }
  for (const auto* text : {"in alarm", "\"in alarm\"", "[\"in alarm\"]", "4"}) {
    EXPECT_EQ(to_text(given("bitsetOutput", kBits, text).value()),
              R"({"raw":4,"fault":false,"in alarm":true,"overridden":false})")
        << text;
  }
  EXPECT_EQ(to_text(given("bitsetOutput", kBits, "[]").value()),
            R"({"raw":0,"fault":false,"in alarm":false,"overridden":false})");
}

TEST(Words, AWrongSetSaysWhatIsWrong) {
  EXPECT_EQ(why_not("bitsetOutput", kBits, "[\"folt\"]"),
            "bitsetOutput: 'folt' is not one of fault, in alarm, overridden, or a number");
  EXPECT_EQ(why_not("bitsetOutput", kBits, R"({"fault": 1})"), "bitsetOutput: 'fault': expected true or false");
  EXPECT_EQ(why_not("bitsetOutput", kBits, R"({"raw": "x"})"), "bitsetOutput: raw: expected a number");
  EXPECT_EQ(why_not("bitsetOutput", kBits, "2"), "bitsetOutput: '2' has bits without a name, expected some of 0xd");
  for (const auto* text : {"-1", "1.5", "null", "true", "[1]", "{", "", "99999999999999999999", "[[\"fault\"]]"}) {
    EXPECT_FALSE(given("bitsetOutput", kBits, text)) << text;
  }
  EXPECT_FALSE(given("bitsetOutput", kBits, std::string(5000, '[')));
}

TEST(Words, BitsThatNoNumberHasAreOff) {
  const std::vector<Word> far{{0, "near"}, {40, "far"}};
  EXPECT_EQ(set_of(far, 0xffffffff).text, R"({"raw":1,"near":true,"far":false})");
  EXPECT_EQ(bits_of(far, "far"), 0U);
}

}  // namespace
}  // namespace rubicon::model
