#include "networks/knx/xml/xml_parser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

namespace rubicon::networks::knx::xml {
namespace {

using ::testing::HasSubstr;

/// Writes what it hears: `<name a=1>`, `text`, `</name>`.
struct Heard final : Listener {
  void start(std::string_view name, const Attributes& attributes) override {
    events += "<" + std::string(name);
    for (std::size_t i = 0; i < attributes.size(); ++i) {
      const auto [key, value] = attributes.at(i);
      events += " " + std::string(key) + "=" + std::string(value);
    }
    events += ">";
    if (name == last && parser != nullptr) parser->enough();
    if (name == refused && parser != nullptr) parser->refuse("no such element, please");
  }
  void end(std::string_view name) override { events += "</" + std::string(name) + ">"; }
  void text(std::string_view text) override { events += text; }

  std::string events, refused, last;
  Parser* parser = nullptr;
  std::optional<Parser> own;
};

Result<void> read(std::string_view document, Heard& heard, std::size_t piece) {
  auto& parser = heard.own.emplace(heard);
  heard.parser = &parser;
  for (; !document.empty(); document.remove_prefix(std::min(piece, document.size()))) {
    if (auto fed = parser.feed(document.substr(0, piece)); !fed) return fed;
  }
  return parser.finish();
}

TEST(XmlParser, GivesTheSameEventsWhateverThePieces) {
  for (const std::size_t piece : {1U, 2U, 7U, 1000U}) {
    Heard heard;
    ASSERT_TRUE(read("\xef\xbb\xbf<?xml version=\"1.0\"?><k:a xmlns:k='u' b='1 &amp; 2'>x<c/>ü</k:a>", heard, piece));
    EXPECT_EQ(heard.events, "<a xmlns:k=u b=1 & 2>x<c></c>ü</a>") << piece;
  }
}

TEST(XmlParser, ADocumentWithADocumentTypeIsRefused) {
  Heard heard;
  const auto bomb = read("<!DOCTYPE a [<!ENTITY b \"bbbb\"><!ENTITY c \"&b;&b;\">]><a>&c;</a>", heard, 1000);
  ASSERT_FALSE(bomb);
  EXPECT_EQ(bomb.error().code, ErrorCode::kRefused);
  EXPECT_EQ(heard.events, "");
}

TEST(XmlParser, DepthIsBounded) {
  std::string deep;
  for (int i = 0; i < 1000; ++i) deep += "<a>";
  Heard heard;
  const auto result = read(deep, heard, 1000);
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().text, HasSubstr("nested 33 deep"));
}

TEST(XmlParser, AfterARefusalTheListenerHearsNothing) {
  Heard heard;
  heard.refused = "b";
  const auto result = read("<a><b>text<c/></b></a>", heard, 1000);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().text, "no such element, please");
  EXPECT_EQ(heard.events, "<a><b>");
}

TEST(XmlParser, WhatFollowsWhatTheListenerNeedsIsNotExamined) {
  Heard heard;
  heard.last = "b";
  EXPECT_TRUE(read("<a><b/>not <well formed", heard, 4));
  EXPECT_EQ(heard.events, "<a><b>");
  EXPECT_TRUE(heard.parser->has_enough());
}

TEST(XmlParser, ATagHasABoundInAnyPieces) {
  for (const auto* begin : {"<a b='", "<a><!-- "}) {
    for (const std::size_t piece : {std::size_t{65'536}, std::size_t{1} << 20U, std::size_t{1} << 26U}) {
      Heard heard;
      const auto result = read(begin + std::string(10'000'000, 'x'), heard, piece);
      ASSERT_FALSE(result);
      EXPECT_THAT(result.error().text, HasSubstr("a tag of more than 8388608 bytes")) << begin << piece;
    }
  }
}

TEST(XmlParser, LongTextHasNoBound) {
  Heard heard;
  EXPECT_TRUE(read("<a>" + std::string(20'000'000, 'x') + "</a>", heard, 65'536));
  EXPECT_EQ(heard.events.size(), 20'000'007U);
}

TEST(XmlParser, SaysWhatIsWrong) {
  Heard heard;
  EXPECT_THAT(read("<a><b></a>", heard, 1000).error().text, HasSubstr("not well-formed"));
  EXPECT_THAT(read("<a><b>", heard, 1000).error().text, HasSubstr("ends inside an element"));
  EXPECT_THAT(read("", heard, 1000).error().text, HasSubstr("ends inside an element"));
  EXPECT_THAT(read("<?xml version='1.0' encoding='x-none'?><a/>", heard, 1000).error().text,
              HasSubstr("encoding is not known, expected UTF-8"));
}

TEST(XmlParser, AnErrorStays) {
  Heard heard;
  Parser parser(heard);
  EXPECT_FALSE(parser.feed("<a></b>"));
  const auto events = heard.events;
  EXPECT_FALSE(parser.feed("<c/>"));
  EXPECT_FALSE(parser.finish());
  EXPECT_EQ(heard.events, events);
}

}  // namespace
}  // namespace rubicon::networks::knx::xml
