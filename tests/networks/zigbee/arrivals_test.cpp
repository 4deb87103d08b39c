#include "networks/zigbee/arrivals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"

namespace rubicon::networks::zigbee {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

class ArrivalsTest : public ::testing::Test {
 protected:
  VirtualScheduler time;
  std::vector<std::string> taken;
  /// Each message of `button` is an event.
  Arrivals arrivals{time,
                    {.take = [this](const transport::MqttMessage& message) { taken.emplace_back(message.payload); },
                     .replaceable = [](const transport::MqttMessage& message) { return message.topic != "button"; }}};
};

TEST_F(ArrivalsTest, AreTakenInOrderInALaterTurn) {
  arrivals.add({"a", "1"});
  arrivals.add({"b", "2"});
  EXPECT_THAT(taken, SizeIs(0));
  time.run_ready();
  EXPECT_THAT(taken, ElementsAre("1", "2"));
}

/// Thousands of states within a moment do not hold the loop: other work runs between them.
TEST_F(ArrivalsTest, ABurstIsTakenInManyTurns) {
  for (int i = 0; i < 3000; ++i) arrivals.add({"a", std::to_string(i)});
  int turns = 0;
  std::function<void()> other = [&] {
    ++turns;
    if (taken.size() < 3000) time.post(other);
  };
  time.post(other);
  time.run_ready();
  EXPECT_THAT(taken, SizeIs(3000));
  EXPECT_GE(turns, 4);
}

TEST_F(ArrivalsTest, BeyondTheBoundTheOldestThatALaterOneReplacesAreDroppedAndCounted) {
  constexpr auto kAll = Arrivals::kMaxMessages + 10;
  for (std::size_t i = 0; i < kAll; ++i) arrivals.add({"a", std::to_string(i)});
  time.run_ready();
  EXPECT_THAT(taken, SizeIs(kAll - arrivals.dropped()));
  EXPECT_LE(taken.size(), Arrivals::kMaxMessages);
  EXPECT_GT(taken.size(), Arrivals::kMaxMessages / 2);
  EXPECT_EQ(taken.front(), std::to_string(arrivals.dropped()));
  EXPECT_EQ(taken.back(), std::to_string(kAll - 1));
}

TEST_F(ArrivalsTest, TheBytesThatWaitAreBounded) {
  const std::string long_one(Arrivals::kMaxBytes / 4, 'x');
  for (int i = 0; i < 5; ++i) arrivals.add({"a", long_one});
  EXPECT_EQ(arrivals.dropped(), 2U);
}

TEST_F(ArrivalsTest, WhatNoLaterMessageRepeatsIsNotDropped) {
  arrivals.add({"button", "press"});
  arrivals.add({"thermometer", "21"});
  arrivals.add({"button", "press again"});
  for (std::size_t i = 0; i < Arrivals::kMaxMessages; ++i) arrivals.add({"lamp", std::to_string(i)});
  time.run_ready();
  EXPECT_GT(arrivals.dropped(), 0U);
  ASSERT_THAT(taken, SizeIs(Arrivals::kMaxMessages + 3 - arrivals.dropped()));
  EXPECT_EQ(taken[0], "press");
  EXPECT_EQ(taken[1], "21");
  EXPECT_EQ(taken[2], "press again");
  EXPECT_EQ(taken[3], std::to_string(arrivals.dropped()));
}

TEST_F(ArrivalsTest, BeyondTwiceTheBoundTheOldestIsDroppedWhateverItIs) {
  for (std::size_t i = 0; i < 2 * Arrivals::kMaxMessages + 3; ++i) arrivals.add({"button", std::to_string(i)});
  EXPECT_EQ(arrivals.dropped(), 3U);
  time.run_ready();
  EXPECT_THAT(taken, SizeIs(2 * Arrivals::kMaxMessages));
  EXPECT_EQ(taken.front(), "3");
}

TEST_F(ArrivalsTest, AreAllTakenAtOnceBeforeWhatChangesTheirMeaning) {
  for (int i = 0; i < 3000; ++i) arrivals.add({"a", std::to_string(i)});
  arrivals.drain();
  EXPECT_THAT(taken, SizeIs(3000));
  time.run_ready();
  EXPECT_THAT(taken, SizeIs(3000));
}

}  // namespace
}  // namespace rubicon::networks::zigbee
