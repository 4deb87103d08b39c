#include "apps/rubicon/live/view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::cli::live {

void PrintTo(const Stroke& stroke, std::ostream* out) {
  *out << static_cast<int>(stroke.key) << " '" << stroke.text << "'";
}

namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using Key = Stroke::Key;

std::vector<Stroke> strokes(std::string_view bytes) {
  return StrokeReader().take(bytes);
}

TEST(Strokes, CharactersComeOneByOne) {
  EXPECT_THAT(strokes("a/K\xc3\xbc"), ElementsAre(Stroke{Key::kText, "a"}, Stroke{Key::kText, "/"},
                                                  Stroke{Key::kText, "K"}, Stroke{Key::kText, "\xc3\xbc"}));
}

TEST(Strokes, EveryTerminalsArrowsAndPageKeysAreTheSame) {
  for (const auto* up : {"\x1b[A", "\x1bOA", "\x1b[1;5A"})
    EXPECT_THAT(strokes(up), ElementsAre(Stroke{Key::kUp})) << up;
  for (const auto* home : {"\x1b[H", "\x1bOH", "\x1b[1~", "\x1b[7~"})
    EXPECT_THAT(strokes(home), ElementsAre(Stroke{Key::kHome})) << home;
  for (const auto* end : {"\x1b[F", "\x1bOF", "\x1b[4~", "\x1b[8~"})
    EXPECT_THAT(strokes(end), ElementsAre(Stroke{Key::kEnd})) << end;
  EXPECT_THAT(strokes("\x1b[B\x1b[5~\x1b[6~\x1b[6;2~"),
              ElementsAre(Stroke{Key::kDown}, Stroke{Key::kPageUp}, Stroke{Key::kPageDown}, Stroke{Key::kPageDown}));
}

TEST(Strokes, ControlKeysEditALine) {
  EXPECT_THAT(
      strokes("\r\n\t\x7f\b\x15\x17\x0c"),
      ElementsAre(Stroke{Key::kEnter}, Stroke{Key::kEnter}, Stroke{Key::kTab}, Stroke{Key::kBackspace},
                  Stroke{Key::kBackspace}, Stroke{Key::kEraseLine}, Stroke{Key::kEraseWord}, Stroke{Key::kRedraw}));
}

TEST(Strokes, ASequenceMayComeInPieces) {
  StrokeReader reader;
  EXPECT_THAT(reader.take("\x1b"), IsEmpty());
  EXPECT_TRUE(reader.pending());
  EXPECT_THAT(reader.take("["), IsEmpty());
  EXPECT_THAT(reader.take("A\xc3"), ElementsAre(Stroke{Key::kUp}));
  EXPECT_THAT(reader.take("\xbc"), ElementsAre(Stroke{Key::kText, "\xc3\xbc"}));
  EXPECT_FALSE(reader.pending());
}

TEST(Strokes, AnEscapeIsAKeyWhenNothingFollows) {
  StrokeReader reader;
  EXPECT_THAT(reader.take("\x1b"), IsEmpty());
  EXPECT_THAT(reader.settle(), ElementsAre(Stroke{Key::kEscape}));
  EXPECT_THAT(reader.settle(), IsEmpty());
  EXPECT_THAT(reader.take("\x1bq"), ElementsAre(Stroke{Key::kEscape}, Stroke{Key::kText, "q"}));
}

TEST(Strokes, WhatIsNotKnownIsIgnored) {
  EXPECT_THAT(strokes("\x1b[200~x\x1b[31mx\x1bOPx\x01x"), testing::Each(Stroke{Key::kText, "x"}));
  EXPECT_THAT(strokes("\xff\xfe"
                      "a"),
              ElementsAre(Stroke{Key::kText, "a"}));
}

TEST(Strokes, ABrokenCharacterHoldsNoKeyBack) {
  for (const auto* broken : {"\xc3", "\xe2\x82", "\xf0\x9f\x98", "\x80", "\xc0", "\xf5", "\xed\xa0\x80"})
    EXPECT_THAT(strokes(broken + std::string("a\r")), ElementsAre(Stroke{Key::kText, "a"}, Stroke{Key::kEnter}));
}

TEST(Strokes, AnEndlessSequenceIsNotKept) {
  StrokeReader reader;
  EXPECT_THAT(reader.take("\x1b[" + std::string(100, '1')), IsEmpty());
  EXPECT_FALSE(reader.pending());
  EXPECT_THAT(reader.take("a"), ElementsAre(Stroke{Key::kText, "a"}));
}

}  // namespace
}  // namespace rubicon::cli::live
