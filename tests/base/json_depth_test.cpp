#include "base/text.h"

#include <gtest/gtest.h>

namespace rubicon::base {
namespace {

TEST(JsonDepth, CountsTheBracketsThatAreOpenAtOnce) {
  EXPECT_FALSE(is_nested_deeper("", 0));
  EXPECT_FALSE(is_nested_deeper("5", 0));
  EXPECT_TRUE(is_nested_deeper("[]", 0));
  EXPECT_FALSE(is_nested_deeper(R"([{"a":[]},{"b":[]},[[]]])", 3));
  EXPECT_TRUE(is_nested_deeper(R"([{"a":[]},{"b":[]},[[]]])", 2));
}

TEST(JsonDepth, BracketsInStringsDoNotCount) {
  EXPECT_FALSE(is_nested_deeper(R"({"[[[":"{{{"})", 1));
  EXPECT_FALSE(is_nested_deeper(R"(["\"[[\\\"["])", 1)) << "the quotation marks are escaped";
  EXPECT_TRUE(is_nested_deeper(R"(["\\",[]])", 1)) << "the backslash is escaped, the string ends";
}

TEST(JsonDepth, ClosingBracketsWithoutOpeningOnesHideNothing) {
  EXPECT_TRUE(is_nested_deeper("]]]][[[", 2));
  EXPECT_TRUE(is_nested_deeper("}}]][[{", 2));
}

TEST(JsonDepth, ATextMayEndAnywhere) {
  for (const auto* text : {"\"", "\"\\", "[\"\\", "[[", "\"[["}) EXPECT_FALSE(is_nested_deeper(text, 2)) << text;
}

}  // namespace
}  // namespace rubicon::base
