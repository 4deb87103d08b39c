#include "trust/site/site_identity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::trust::site {
namespace {

using testing::HasSubstr;

std::string why(std::string_view name) {
  const auto checked = check_user_name(name);
  return checked ? "" : checked.error().text;
}

TEST(UserNames, OrdinaryOnesAreTaken) {
  for (const auto* name : {"hall", "ann", "lab-2", "a", "7", "House_7.north", "island-7"})
    EXPECT_EQ(why(name), "") << name;
  EXPECT_EQ(why(std::string(64, 'x')), "");
}

TEST(UserNames, TheReasonAgainstEachCharacterIsSaid) {
  EXPECT_THAT(why("hall/c1"), HasSubstr("another level of a topic"));
  EXPECT_THAT(why("a+"), HasSubstr("stands for any level"));
  EXPECT_THAT(why("a#"), HasSubstr("stands for all levels"));
  EXPECT_THAT(why("user:ann"), HasSubstr("source in rights"));
  EXPECT_THAT(why("ann@hall"), HasSubstr("vouches"));
  EXPECT_THAT(why("ann lee"), HasSubstr("access lists"));
  EXPECT_THAT(why("caf\xc3\xa9"), HasSubstr("expected 1 to 64 letters"));
  EXPECT_THAT(why(".."), HasSubstr("the first one a letter or digit"));
  EXPECT_THAT(why(std::string(65, 'x')), HasSubstr("it has 65 bytes, expected at most 64"));
  EXPECT_THAT(why(""), HasSubstr("is empty"));
  EXPECT_THAT(why(std::string_view("a\0b", 3)), HasSubstr("expected 1 to 64 letters"));
  EXPECT_THAT(why("a\nuser b"), HasSubstr("not a name of a member"));
}

TEST(UserNames, WordsThatMeanSomethingElseAreTaken) {
  EXPECT_THAT(why("-"), HasSubstr("a user without a name"));
  EXPECT_THAT(why("-probe-"), HasSubstr("members try whether"));
  for (const auto* name : {"peis", "lan", "everybody", "all", "admin"})
    EXPECT_THAT(why(name), HasSubstr("it means something else in")) << name;
}

TEST(UserNames, ANameOfAnIslandIsForThatIslandOnly) {
  EXPECT_TRUE(check_island_of("island-7", {OwnerId{7}}));
  EXPECT_TRUE(check_island_of("island-x", {}));
  EXPECT_TRUE(check_island_of("hall", {OwnerId{7}}));
  for (const auto& islands : std::vector<std::vector<OwnerId>>{{}, {OwnerId{8}}}) {
    const auto checked = check_island_of("island-7", islands);
    ASSERT_FALSE(checked);
    EXPECT_THAT(checked.error().text, HasSubstr("expected --island 7"));
  }
}

}  // namespace
}  // namespace rubicon::trust::site
