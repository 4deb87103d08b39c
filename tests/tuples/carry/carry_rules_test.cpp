#include "tuples/carry/carry_rules.h"

#include <gmock/gmock.h>

namespace rubicon::tuples::carry {
namespace {

using testing::HasSubstr;
using testing::Optional;

TEST(CarryRules, KnowTheKeysThatTwoPatternsHaveInCommon) {
  EXPECT_THAT(common_keys("**", "a.b"), Optional(std::string("a.b")));
  EXPECT_THAT(common_keys("**", "**"), Optional(std::string("**")));
  EXPECT_THAT(common_keys("kitchen.**", "**"), Optional(std::string("kitchen.**")));
  EXPECT_THAT(common_keys("kitchen.**", "*.*.value"), Optional(std::string("kitchen.*.value")));
  EXPECT_THAT(common_keys("a.*", "*.b"), Optional(std::string("a.b")));
  EXPECT_THAT(common_keys("a.**", "a"), Optional(std::string("a"))) << "** is also no part";
  EXPECT_THAT(common_keys("a.**", "a.b.**"), Optional(std::string("a.b.**")));
  EXPECT_EQ(common_keys("a.**", "b.**"), std::nullopt);
  EXPECT_EQ(common_keys("a.*", "a"), std::nullopt);
  EXPECT_EQ(common_keys("a.b.c.**", "a.*"), std::nullopt);
}

TEST(CarryRules, RefuseNumbersThatAreNoIds) {
  CarryRules rules;
  for (const auto* entry : {"0", "-5", "3.0", "02", "2147483648"})
    EXPECT_THAT(add_entry(rules, entry).error().text, HasSubstr("1 to 2147483647")) << entry;
  EXPECT_TRUE(rules.empty());
  EXPECT_TRUE(add_entry(rules, "3d.**"));
}

TEST(CarryRules, CarryAllOfAnIdAndPatternsOfEveryComponent) {
  CarryRules rules;
  for (const auto* text : {"4711", "kitchen.**", "*.name"}) ASSERT_TRUE(add_entry(rules, text)) << text;
  EXPECT_TRUE(rules.carries(OwnerId(4711), "anything"));
  EXPECT_TRUE(rules.carries(OwnerId(1), "kitchen.lamp"));
  EXPECT_TRUE(rules.carries(OwnerId(1), "hall.name"));
  EXPECT_FALSE(rules.carries(OwnerId(1), "hall.lamp"));
}

TEST(CarryRules, RefuseWhatIsNeitherIdNorPattern) {
  CarryRules rules;
  for (const auto* text : {"0", "2147483648", "99999999999", "", "a..b", "a.**.b", "7:a", "a b"})
    EXPECT_FALSE(add_entry(rules, text)) << text;
  EXPECT_THAT(add_entry(rules, "7:a").error().text, HasSubstr("not both"));
  EXPECT_TRUE(rules.empty());
}

}  // namespace
}  // namespace rubicon::tuples::carry
