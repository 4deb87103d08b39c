#include "tuples/member_ids.h"

#include <gtest/gtest.h>

#include <set>

namespace rubicon::tuples {
namespace {

Member member(std::vector<IdRange> ids) {
  Member one;
  one.name = "desk";
  one.ids = std::move(ids);
  return one;
}

TEST(MemberIds, OfFurtherComponentsAreRandomOnesOfTheBlock) {
  const auto island = member({{7, 7}, {0x01a00000, 0x01afffff}});
  std::set<OwnerId> seen;
  for (int i = 0; i < 100; ++i) {
    const auto id = random_id(island);
    EXPECT_TRUE(island.may_use(id));
    EXPECT_NE(id, OwnerId(7));
    seen.insert(id);
  }
  EXPECT_GT(seen.size(), 90U);
  EXPECT_EQ(random_id(member({})), model::kNoOwner);
}

TEST(MemberIds, AreShownAsPartitionsHaveThem) {
  EXPECT_EQ(text_of_ids(member({{7, 7}, {0x01a00000, 0x01afffff}})), "00000007, 01a00000-01afffff");
  EXPECT_EQ(text_of_ids(member({})), "none");
}

}  // namespace
}  // namespace rubicon::tuples
