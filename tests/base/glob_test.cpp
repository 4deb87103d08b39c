#include "base/compare_text.h"

#include <gtest/gtest.h>

#include <string>

namespace rubicon::base {
namespace {

TEST(Glob, PlainTextMatchesItselfOnly) {
  EXPECT_TRUE(glob_matches("wsn-1", "wsn-1"));
  EXPECT_FALSE(glob_matches("wsn-1", "wsn-10"));
  EXPECT_FALSE(glob_matches("wsn-10", "wsn-1"));
  EXPECT_TRUE(glob_matches("", ""));
  EXPECT_FALSE(glob_matches("", "x"));
}

TEST(Glob, AStarTakesAnyTextAndAQuestionMarkOneCharacter) {
  EXPECT_TRUE(glob_matches("wsn-*", "wsn-"));
  EXPECT_TRUE(glob_matches("wsn-*", "wsn-hall"));
  EXPECT_TRUE(glob_matches("*.4.*", "1.4.6"));
  EXPECT_FALSE(glob_matches("*.4.*", "1.5.6"));
  EXPECT_TRUE(glob_matches("1.?.6", "1.4.6"));
  EXPECT_FALSE(glob_matches("1.?.6", "1..6"));
  EXPECT_TRUE(glob_matches("**", "x"));
  EXPECT_TRUE(glob_matches("*a*b", "xaxbxb"));
}

TEST(Glob, ManyStarsEndQuickly) {
  EXPECT_FALSE(glob_matches("*a*a*a*a*a*a*a*a*b", std::string(10000, 'a')));
}

}  // namespace
}  // namespace rubicon::base
