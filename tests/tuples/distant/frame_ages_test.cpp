#include "tuples/distant/frame_codec.h"

#include <gtest/gtest.h>

namespace rubicon::tuples::distant {
namespace {

using namespace std::chrono_literals;

/// Two components; the clock of the commander is behind by a day.
struct Ages : testing::Test {
  Duration of_commander() const { return now - 24h; }
  /// A frame to the other side, which takes so long.
  void to_commander(Duration takes) {
    const auto times = owner.next(now, true);
    now += takes;
    commander.arrived(times, of_commander());
  }
  void to_owner(Duration takes) {
    const auto times = commander.next(of_commander(), false);
    now += takes;
    owner.arrived(times, now);
  }

  Duration now = 100h;
  FrameAges owner, commander;
};

TEST_F(Ages, AreNotKnownBeforeAnEcho) {
  const auto sent = of_commander();
  to_owner(1ms);
  EXPECT_FALSE(owner.age(sent, now, 1h));
}

TEST_F(Ages, AreTrueOrLongerByTheTimeOfAnExchange) {
  const auto sent = of_commander();
  to_owner(1500ms);
  to_commander(20ms);
  now += 5s;  // held
  to_owner(300ms);
  const auto age = owner.age(sent, now, 1h);
  ASSERT_TRUE(age);
  EXPECT_GE(*age, 1500ms + 20ms + 5s + 300ms);
  EXPECT_LE(*age, 1500ms + 20ms + 5s + 300ms + 20ms + 10ms) << "and the drift";
}

/// The only exchange went through a broker that was down for a while.
TEST_F(Ages, AreAskedForAgainWhereALongExchangeMayHideATimeToLive) {
  to_commander(10s);
  to_owner(1ms);
  const auto sent = of_commander();
  now += 1ms;
  EXPECT_FALSE(owner.age(sent, now, 5s)) << "it is between 1 ms and 10 s";
  EXPECT_TRUE(owner.age(sent, now, 20s)) << "less in any case";
  const auto old = of_commander();
  now += 7s;
  EXPECT_TRUE(owner.age(old, now, 5s)) << "more in any case";
  to_commander(1ms);
  to_owner(1ms);
  EXPECT_TRUE(owner.age(of_commander(), now, 5s));
}

TEST_F(Ages, KeepTheQuickestExchange) {
  to_commander(1ms);
  to_owner(1ms);
  to_commander(800ms);
  to_owner(1ms);
  const auto sent = of_commander();
  now += 10ms;
  EXPECT_LE(*owner.age(sent, now, 1h), 10ms + 1ms + 1ms);
}

TEST_F(Ages, GrowWithTheDriftUntilTheyAreNotKnown) {
  to_commander(1ms);
  to_owner(1ms);
  now += 60s;
  const auto age = owner.age(of_commander(), now, 1h);
  ASSERT_TRUE(age);
  EXPECT_GE(*age, 60s / FrameAges::kDriftParts);
  now += 60s;
  EXPECT_FALSE(owner.age(of_commander(), now, 1h)) << "the clocks may have drifted by more than kMaxSlack";
}

TEST_F(Ages, AreNotKnownByAnEchoThatWasHeldForLong) {
  to_commander(1ms);
  now += 200s;
  to_owner(1ms);
  EXPECT_FALSE(owner.age(of_commander(), now, 1h));
}

TEST_F(Ages, AreNotKnownAfterTheOwnClockStoodStill) {
  to_commander(1ms);
  to_owner(1ms);
  owner.arrived({of_commander() + 10s, {}, {}, false}, now);
  EXPECT_FALSE(owner.age(of_commander(), now, 1h));
}

}  // namespace
}  // namespace rubicon::tuples::distant
