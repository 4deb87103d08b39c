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
  Arrivals arrivals{time, [this](const transport::MqttMessage& message) { taken.emplace_back(message.payload); }};
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

TEST_F(ArrivalsTest, BeyondTheBoundTheOldestIsDroppedAndCounted) {
  for (std::size_t i = 0; i < Arrivals::kMaxMessages + 10; ++i) arrivals.add({"a", std::to_string(i)});
  time.run_ready();
  EXPECT_THAT(taken, SizeIs(Arrivals::kMaxMessages));
  EXPECT_EQ(taken.front(), "10");
  EXPECT_EQ(arrivals.dropped(), 10U);
  const std::string long_one(Arrivals::kMaxBytes / 4, 'x');
  for (int i = 0; i < 5; ++i) arrivals.add({"a", long_one});
  EXPECT_EQ(arrivals.dropped(), 12U);
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
