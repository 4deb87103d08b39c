#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// The same rules near and far: the parameter says whether the subscriber is the owner or a distant component.
struct FlowControl : testing::TestWithParam<bool>, TwoComponents {
  Handle subscribe(const Flow& flow) {
    auto handle = (GetParam() ? robot : island)->space.subscribe(pattern("*:a"), flow, listener.call());
    time.run_ready();
    return handle;
  }
  Seen after(std::string_view value) {
    EXPECT_TRUE(island->space.set("a", value));
    time.run_ready();
    return listener.take();
  }
  Seen waiting(Duration span) {
    time.run_for(span);
    return listener.take();
  }
  Listener listener;
};

TEST_P(FlowControl, TheMinimumIntervalDeliversTheLatestAtItsEnd) {
  const auto handle = subscribe({.minimum = 10s});
  EXPECT_THAT(after("1"), ElementsAre("a=1"));
  EXPECT_THAT(after("2"), IsEmpty());
  time.run_for(4s);
  EXPECT_THAT(after("3"), IsEmpty());
  EXPECT_THAT(waiting(6s - 1ns), IsEmpty());
  EXPECT_THAT(waiting(1ns), ElementsAre("a=3"));
  EXPECT_THAT(waiting(1h), IsEmpty());
  EXPECT_THAT(after("4"), ElementsAre("a=4"));
}

TEST_P(FlowControl, AnInitialValueOpensTheInterval) {
  ASSERT_TRUE(island->space.set("a", "1"));
  const auto handle = subscribe({.minimum = 10s});
  EXPECT_THAT(listener.take(), ElementsAre("a=1"));
  EXPECT_THAT(after("2"), IsEmpty());
  EXPECT_THAT(waiting(10s), ElementsAre("a=2"));
}

TEST_P(FlowControl, TheMaximumIntervalRepeatsThePresentValue) {
  const auto handle = subscribe({.maximum = 10s});
  EXPECT_THAT(after("1"), ElementsAre("a=1"));
  time.run_for(5s);
  EXPECT_THAT(after("2"), ElementsAre("a=2"));
  EXPECT_THAT(waiting(10s - 1ns), IsEmpty());
  EXPECT_THAT(waiting(1ns), ElementsAre("a=2"));
  EXPECT_THAT(waiting(30s), ElementsAre("a=2", "a=2", "a=2"));
}

TEST_P(FlowControl, TheDeadBandHoldsSmallChangesBack) {
  const auto handle = subscribe({.dead_band = 0.5});
  EXPECT_THAT(after("20"), ElementsAre("a=20"));
  EXPECT_THAT(after("20.3"), IsEmpty());
  EXPECT_THAT(after("20.4"), IsEmpty());
  EXPECT_THAT(after("20.5"), ElementsAre("a=20.5"));
  EXPECT_THAT(after("20"), ElementsAre("a=20"));
  EXPECT_THAT(after("off"), ElementsAre("a=off"));
  EXPECT_THAT(after("off"), ElementsAre("a=off"));
  EXPECT_THAT(waiting(1h), IsEmpty());
}

TEST_P(FlowControl, AValueBackInTheDeadBandAtTheEndOfTheIntervalIsNotTold) {
  const auto handle = subscribe({.minimum = 10s, .dead_band = 1});
  EXPECT_THAT(after("20"), ElementsAre("a=20"));
  EXPECT_THAT(after("25"), IsEmpty());
  EXPECT_THAT(after("20.5"), IsEmpty());
  EXPECT_THAT(waiting(1h), IsEmpty());
  EXPECT_THAT(after("25"), ElementsAre("a=25"));
}

TEST_P(FlowControl, DeletionIsToldAtOnce) {
  const auto handle = subscribe({.minimum = 10s, .maximum = 20s});
  EXPECT_THAT(after("1"), ElementsAre("a=1"));
  EXPECT_THAT(after("2"), IsEmpty());
  ASSERT_TRUE(island->space.erase("a"));
  time.run_ready();
  EXPECT_THAT(listener.take(), ElementsAre("a deleted"));
  EXPECT_THAT(waiting(1h), IsEmpty());
  EXPECT_THAT(after("3"), ElementsAre("a=3"));
}

TEST_P(FlowControl, NothingComesAfterTheHandleIsGone) {
  auto handle = subscribe({.minimum = 10s, .maximum = 20s});
  EXPECT_THAT(after("1"), ElementsAre("a=1"));
  EXPECT_THAT(after("2"), IsEmpty());
  handle.reset();
  EXPECT_THAT(waiting(1h), IsEmpty());
}

TEST_P(FlowControl, ExtremeIntervalsAreHarmless) {
  const auto handle = subscribe({.minimum = Duration::max(), .maximum = Duration::max()});
  const auto other = subscribe({.minimum = Duration::min(), .maximum = Duration::min(), .dead_band = -1});
  EXPECT_THAT(after("1"), ElementsAre("a=1", "a=1"));
  EXPECT_THAT(after("2"), ElementsAre("a=2"));
}

INSTANTIATE_TEST_SUITE_P(NearAndFar, FlowControl, testing::Bool(),
                         [](const auto& p) { return p.param ? "Far" : "Near"; });

TEST(Heartbeat, StopsWhileTheOwnerIsOutOfReach) {
  TwoComponents two;
  Listener listener;
  const auto handle = two.robot->space.subscribe(pattern("a"), {.maximum = 10s}, listener.call());
  ASSERT_TRUE(two.island->space.set("a", "1"));
  two.time.run_for(10s);
  EXPECT_EQ(listener.take().size(), 2u);
  two.ecology.cut(two.kIsland, two.kRobot);
  two.time.run_for(kOwnerGrace - 5s);
  EXPECT_THAT(listener.take(), IsEmpty());
  two.ecology.mend(two.kIsland, two.kRobot);
  two.time.run_for(1min);
  EXPECT_EQ(listener.take().size(), 6u);
}

}  // namespace
}  // namespace rubicon::tuples
