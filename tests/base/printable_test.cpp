#include "base/text.h"

#include <gtest/gtest.h>

namespace rubicon::base {
namespace {

TEST(TextOfOutsiders, OneLineHasBlanksForLineEnds) {
  EXPECT_EQ(one_line("a\nb\tc\x1b[2J"), "a b c [2J");
  EXPECT_EQ(one_line("\xff"), "?");
}

TEST(Printable, LettersOfAllLanguagesStay) {
  for (const auto* text : {"Küche", "中文", "Ελλάδα", "עברית", "€", "😀"}) EXPECT_EQ(printable(text), text);
}

TEST(Printable, ControlsAndBrokenBytesBecomeQuestionMarks) {
  EXPECT_EQ(printable("a\x1b[2Jb\nc\x7f"), "a?[2Jb?c?");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J"),
            "?2J");
  EXPECT_EQ(printable("\xff\xc3"), "??");
}

TEST(Printable, MarksThatTurnTheDirectionOfTextDoNotReachTheScreen) {
  for (const auto* mark : {"\u061c", "\u200e", "\u200f", "\u2028", "\u2029", "\u202a", "\u202b", "\u202c", "\u202d",
                           "\u202e", "\u2066", "\u2067", "\u2068", "\u2069"}) {
    EXPECT_EQ(printable(std::string("a") + mark + "z"), "a?z") << mark;
  }
  for (const auto* neighbour : {"\u061b", "\u200d", "\u2010", "\u2027", "\u202f", "\u2065", "\u206a"})
    EXPECT_EQ(printable(neighbour), neighbour);
}

TEST(Printable, FittedCutsAndPadsByCharacters) {
  EXPECT_EQ(fitted("Küche", 2), "Kü");
  EXPECT_EQ(fitted("Küche", 7), "Küche  ");
  EXPECT_EQ(characters("Küche"), 5U);
  EXPECT_EQ(characters("\x9f\x9f"), 1U);
}

}  // namespace
}  // namespace rubicon::base
