#include "tuples/dds/heard_lists.h"

#include <gmock/gmock.h>

#include "base/virtual_scheduler.h"

namespace rubicon::tuples::dds {
namespace {

using testing::ElementsAre;

struct HeardListsTest : testing::Test {
  base::VirtualScheduler scheduler;
  std::vector<std::string> checked, members;
  HeardLists lists{scheduler, [this](std::string list, const std::string& member) {
                     checked.push_back(std::move(list));
                     members.push_back(member);
                   }};
};

TEST_F(HeardListsTest, AFewAreCheckedAtOnceAndThenTheLastOneOfEachPause) {
  for (const auto* list : {"1", "2", "3", "4", "5", "6"}) lists.hear("mallory", list);
  EXPECT_THAT(checked, ElementsAre("1", "2", "3", "4"));
  scheduler.run_for(HeardLists::kPause);
  EXPECT_THAT(checked, ElementsAre("1", "2", "3", "4", "6"));
  for (int i = 0; i < 1000; ++i) lists.hear("mallory", std::to_string(i));
  scheduler.run_for(3 * HeardLists::kPause);
  EXPECT_EQ(checked.size(), 6U) << "nothing waits any more";
  EXPECT_EQ(checked.back(), "999");
}

TEST_F(HeardListsTest, OneMemberDoesNotDelayAnother) {
  for (int i = 0; i < 100; ++i) lists.hear("mallory", std::to_string(i));
  checked.clear();
  lists.hear("desk", "good");
  EXPECT_THAT(checked, ElementsAre("good"));
}

TEST_F(HeardListsTest, AListKeepsTheNameOfItsMemberWhileItWaits) {
  for (int i = 0; i < 5; ++i) lists.hear("mallory", std::to_string(i));
  lists.hear("desk", "good");
  scheduler.run_for(HeardLists::kPause);
  EXPECT_THAT(members, ElementsAre("mallory", "mallory", "mallory", "mallory", "desk", "mallory"));
}

TEST_F(HeardListsTest, WhoRestsMaySendAFewAgain) {
  for (int i = 0; i < 4; ++i) lists.hear("desk", std::to_string(i));
  scheduler.run_for(4 * HeardLists::kPause);
  for (int i = 4; i < 8; ++i) lists.hear("desk", std::to_string(i));
  EXPECT_EQ(checked.size(), 8U);
}

TEST_F(HeardListsTest, ManyMembersShareWhatIsLeft) {
  for (std::size_t i = 0; i < HeardLists::kMaxMembers + 100; ++i) {
    for (int j = 0; j < 4; ++j) lists.hear(std::to_string(i), std::to_string(j));
  }
  EXPECT_EQ(checked.size(), 4 * (HeardLists::kMaxMembers + 1));
}

}  // namespace
}  // namespace rubicon::tuples::dds
