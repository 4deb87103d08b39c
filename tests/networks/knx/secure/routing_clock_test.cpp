#include "networks/knx/secure/routing_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "base/virtual_scheduler.h"

namespace rubicon::networks::knx::secure {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr Serial kOwn{1, 1, 1, 1, 1, 1}, kOther{2, 2, 2, 2, 2, 2};

/// L = 1 s: q = 100 ms; the group has 3.3 s to answer.
struct Clock : testing::Test {
  struct Notify {
    SteadyTime at{};
    std::uint64_t timer = 0;
    Serial serial{};
    std::uint16_t tag = 0;
  };

  void make(std::uint64_t start = 1'000'000, std::uint64_t seed = 1) {
    sent.clear();
    clock = std::make_unique<RoutingClock>(
        time, RoutingClock::Settings{1s, kOwn, start, seed},
        RoutingClock::Callbacks{[this](const Serial& serial, std::uint16_t tag) {
                                  sent.push_back({time.now(), clock->now(), serial, tag});
                                },
                                [this] { ++synchronised; }});
  }
  void make_keeper() {
    make();
    clock->start();
    time.run_for(4s);
    ASSERT_TRUE(clock->keeper());
    sent.clear();
  }
  void make_follower() {
    make();
    clock->start();
    clock->received_notify(clock->now(), kOwn, sent.at(0).tag);
    ASSERT_TRUE(clock->synchronised());
    ASSERT_FALSE(clock->keeper());
    sent.clear();
  }
  /// When the clock sends its next notify, from now on.
  Duration next_notify() {
    const auto begin = time.now();
    sent.clear();
    while (sent.empty() && time.now() - begin < 30s) time.run_for(1ms);
    return time.now() - begin;
  }

  VirtualScheduler time;
  std::vector<Notify> sent;
  int synchronised = 0;
  std::unique_ptr<RoutingClock> clock;
};

TEST_F(Clock, AsksForTheTimerOfTheGroupAndTakesTheAnswer) {
  make(5);
  clock->start();
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0].serial, kOwn);
  EXPECT_EQ(sent[0].timer, 5u);
  EXPECT_EQ(clock->received_wrapper(900'000, kOther, 7), RoutingClock::Verdict::kEarly);
  clock->received_notify(800'000, kOther, 7);
  clock->received_notify(900'000, kOwn, static_cast<std::uint16_t>(sent[0].tag + 1));
  EXPECT_FALSE(clock->synchronised()) << "neither is the answer to our tag";
  clock->received_notify(950'000, kOwn, sent[0].tag);
  EXPECT_TRUE(clock->synchronised());
  EXPECT_EQ(synchronised, 1);
  EXPECT_FALSE(clock->keeper());
  EXPECT_EQ(clock->now(), 950'000u);
  time.run_for(250ms);
  EXPECT_EQ(clock->now(), 950'250u);
}

TEST_F(Clock, IsKeeperIfNoMemberAnswersInTime) {
  make();
  clock->start();
  time.run_for(3300ms - 1ms);
  EXPECT_FALSE(clock->synchronised());
  time.run_for(1ms);
  EXPECT_TRUE(clock->keeper());
  EXPECT_EQ(synchronised, 1);
  EXPECT_THAT(sent, SizeIs(1));
}

TEST_F(Clock, JudgesWrappersByTheTable) {
  make_keeper();
  const auto own = clock->now();
  EXPECT_EQ(clock->received_wrapper(own, kOther, 1), RoutingClock::Verdict::kAccepted);
  EXPECT_EQ(clock->received_wrapper(own - 99, kOther, 2), RoutingClock::Verdict::kAccepted);
  EXPECT_EQ(clock->received_wrapper(own - 999, kOther, 3), RoutingClock::Verdict::kAccepted);
  EXPECT_EQ(clock->now(), own);
  EXPECT_EQ(clock->received_wrapper(own - 1000, kOther, 4), RoutingClock::Verdict::kOld);
  EXPECT_EQ(clock->received_wrapper(own + 5000, kOther, 5), RoutingClock::Verdict::kAccepted);
  EXPECT_EQ(clock->now(), own + 5000) << "a later timer is taken over";
  EXPECT_TRUE(clock->keeper()) << "a wrapper makes no follower";
}

TEST_F(Clock, CorrectsAnOldTimerAfterADelayByRole) {
  for (const bool keeper : {true, false}) {
    keeper ? make_keeper() : make_follower();
    std::ignore = clock->received_wrapper(clock->now() - 2000, kOther, 77);
    const auto after = next_notify();
    ASSERT_THAT(sent, SizeIs(1));
    EXPECT_EQ(sent[0].serial, kOther);
    EXPECT_EQ(sent[0].tag, 77);
    EXPECT_GE(after, keeper ? 100ms : 300ms);
    EXPECT_LE(after, keeper ? 200ms : 1300ms);
    EXPECT_TRUE(clock->keeper()) << "who sends a notify keeps the timer";
  }
}

TEST_F(Clock, OneCorrectionIsPendingAtATimeAndWrappersDoNotDelayIt) {
  make_keeper();
  std::ignore = clock->received_wrapper(clock->now() - 2000, kOther, 77);
  clock->received_notify(clock->now() - 2000, kOther, 78);
  time.run_for(90ms);
  std::ignore = clock->received_wrapper(clock->now(), kOther, 79);
  clock->sent_wrapper();
  time.run_for(110ms);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0].tag, 77);
}

TEST_F(Clock, AnotherMembersCorrectionReplacesOurs) {
  make_follower();
  std::ignore = clock->received_wrapper(clock->now() - 2000, kOther, 77);
  time.run_for(200ms);
  clock->received_notify(clock->now(), kOther, 77);
  time.run_for(5s);
  EXPECT_THAT(sent, IsEmpty());
}

TEST_F(Clock, SendsItsTimerPeriodicallyAsKeeperAndLaterAsFollower) {
  make_keeper();
  std::ignore = clock->received_wrapper(clock->now(), kOther, 1);
  const auto keeper = next_notify();
  EXPECT_GE(keeper, 10s);
  EXPECT_LE(keeper, 10300ms);
  clock->received_notify(clock->now(), kOther, 2);
  EXPECT_FALSE(clock->keeper());
  const auto follower = next_notify();
  EXPECT_GE(follower, 10400ms);
  EXPECT_LE(follower, 11400ms);
  EXPECT_TRUE(clock->keeper());
}

TEST_F(Clock, NotifiesWithinTheToleranceButLateChangeNothing) {
  make_keeper();
  clock->received_notify(clock->now() - 500, kOther, 1);
  EXPECT_TRUE(clock->keeper());
  time.run_for(5s);
  EXPECT_THAT(sent, IsEmpty());
}

TEST_F(Clock, AWrapperOfOursPostponesTheNotify) {
  make_keeper();
  time.run_for(5s);
  clock->sent_wrapper();
  EXPECT_GE(next_notify(), 10s);
}

TEST_F(Clock, StopsAtTheEndOfItsBits) {
  make(RoutingClock::kMaxTimer - 10);
  clock->start();
  time.run_for(4s);
  EXPECT_EQ(clock->now(), RoutingClock::kMaxTimer);
  std::ignore = clock->received_wrapper(~0ULL, kOther, 1);
  EXPECT_EQ(clock->now(), RoutingClock::kMaxTimer);
}

TEST_F(Clock, DoesNothingWhileItIsStopped) {
  make_keeper();
  clock->stop();
  EXPECT_EQ(clock->received_wrapper(clock->now(), kOther, 1), RoutingClock::Verdict::kEarly);
  clock->received_notify(clock->now() + 5000, kOther, 2);
  const auto before = clock->now();
  time.run_for(1min);
  EXPECT_THAT(sent, IsEmpty());
  EXPECT_EQ(clock->now(), before + 60'000) << "the timer itself runs on";
  clock->start();
  time.run_for(4s);
  EXPECT_TRUE(clock->keeper());
  EXPECT_EQ(synchronised, 2);
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
