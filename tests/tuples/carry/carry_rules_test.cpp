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
  CarryRule rule;
  for (const auto* entry : {"0", "-5", "3.0", "02", "2147483648"})
    EXPECT_THAT(add_entry(rule, entry).error().text, HasSubstr("1 to 2147483647")) << entry;
  EXPECT_EQ(rule, CarryRule());
  EXPECT_TRUE(add_entry(rule, "3d.**"));
}

TEST(CarryRules, CarryAllOfAnIdAndPatternsOfEveryComponent) {
  CarryRules rules{{{}}};
  for (const auto* text : {"4711", "kitchen.**", "*.name"}) ASSERT_TRUE(add_entry(rules.rules[0], text)) << text;
  const Way way{"dds", "mqtt"};
  EXPECT_TRUE(rules.carries(OwnerId(4711), "anything", way));
  EXPECT_TRUE(rules.carries(OwnerId(1), "kitchen.lamp", way));
  EXPECT_TRUE(rules.carries(OwnerId(1), "hall.name", way));
  EXPECT_FALSE(rules.carries(OwnerId(1), "hall.lamp", way));
}

TEST(CarryRules, HoldForTheirWays) {
  const CarryRules rules{{{{OwnerId(7)}, {}, {"dds"}, {"mqtt", "host"}}, {{}, {"a.*"}, {}, {"mqtt"}}}};
  EXPECT_THAT(rules.keys_of(OwnerId(7), {"dds", "mqtt"}), testing::ElementsAre("**"));
  EXPECT_THAT(rules.keys_of(OwnerId(7), {"host", "mqtt"}), testing::ElementsAre("a.*"));
  EXPECT_THAT(rules.keys_of(OwnerId(8), {"dds", "mqtt"}), testing::ElementsAre("a.*"));
  EXPECT_TRUE(rules.carries_any_of(OwnerId(7), {"dds", "host"}));
  EXPECT_FALSE(rules.carries_any_of(OwnerId(8), {"dds", "host"}));
  EXPECT_FALSE(rules.carries_any_of(OwnerId(7), {"mqtt", "dds"}));
}

TEST(CarryRules, AreEqualForAPairWhateverElseTheySay) {
  const CarryRule one{{OwnerId(7)}, {"a.*"}, {}, {}}, two{{}, {"a.*"}, {}, {}}, more{{OwnerId(7)}, {}, {}, {}};
  const CarryRules whole{{one}}, parts{{two, more, {{OwnerId(9)}, {}, {"host"}, {}}}};
  EXPECT_EQ(whole.digest("dds", "mqtt"), parts.digest("mqtt", "dds"));
  EXPECT_NE(whole.digest("host", "mqtt"), parts.digest("host", "mqtt"));
  EXPECT_NE(whole.digest("dds", "mqtt"), whole.digest("dds", "peis"));
  EXPECT_EQ(CarryRules({{{{OwnerId(7)}, {}, {"dds"}, {"host"}}}}).digest("dds", "mqtt"), "");
  EXPECT_EQ(whole.digest("dds", "mqtt"), "8fbd9d134369d819") << "the same in every release";
}

TEST(CarryRules, RefuseWhatIsNeitherIdNorPattern) {
  CarryRule rule;
  for (const auto* text : {"0", "2147483648", "99999999999", "", "a..b", "a.**.b", "7:a", "a b"})
    EXPECT_FALSE(add_entry(rule, text)) << text;
  EXPECT_THAT(add_entry(rule, "7:a").error().text, HasSubstr("not both"));
  EXPECT_EQ(rule, CarryRule());
}

}  // namespace
}  // namespace rubicon::tuples::carry
