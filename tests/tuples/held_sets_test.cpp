#include <gtest/gtest.h>

#include "tuples/remote_sets.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;

RemoteSet set_for(std::uint32_t owner, Duration lives) {
  RemoteSet set;
  set.owner = OwnerId(owner);
  set.key = "lamp";
  set.time_to_live = lives;
  return set;
}

TEST(HeldSetsTest, WhatEndedMeanwhileIsNotSentLater) {
  HeldSets held;
  const SteadyTime begin{1h};
  EXPECT_TRUE(held.hold(set_for(1, 5s), begin));
  EXPECT_TRUE(held.hold(set_for(1, 0s), begin));
  EXPECT_TRUE(held.hold(set_for(1, 10s), begin + 1s));
  const auto due = held.take(OwnerId(1), begin + 5s);
  ASSERT_EQ(due.size(), 2U);
  EXPECT_EQ(due.at(0).time_to_live, 0s) << "without an end";
  EXPECT_EQ(due.at(1).time_to_live, 6s);
}

/// Wires count in whole microseconds.
TEST(HeldSetsTest, LessThanAMicrosecondIsNoTimeWithoutAnEnd) {
  HeldSets held;
  EXPECT_TRUE(held.hold(set_for(1, 5s), SteadyTime{}));
  EXPECT_TRUE(held.take(OwnerId(1), SteadyTime{} + 5s - 1ns).empty());
}

TEST(HeldSetsTest, WhatEndedTakesNoRoom) {
  HeldSets held;
  const SteadyTime begin{1h};
  for (std::size_t i = 0; i < HeldSets::kMax; ++i) EXPECT_TRUE(held.hold(set_for(1, 1s), begin));
  EXPECT_FALSE(held.hold(set_for(2, 1s), begin));
  EXPECT_TRUE(held.hold(set_for(2, 1s), begin + 2s));
  EXPECT_EQ(held.owners(), std::vector{OwnerId(2)});
}

}  // namespace
}  // namespace rubicon::tuples
