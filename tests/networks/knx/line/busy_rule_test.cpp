#include "networks/knx/line/pauses.h"

#include <gtest/gtest.h>

#include <set>

namespace rubicon::networks::knx::line {
namespace {

using namespace std::chrono_literals;

const SteadyTime kStart = SteadyTime() + 1h;

TEST(BusyRule, ThePauseIsTheWaitAndARandomPartOfFiftyMilliseconds) {
  std::set<Duration> seen;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    BusyRule rule(seed);
    EXPECT_LE(rule.resume_at(), kStart) << "no router was busy yet";
    rule.receive(kStart, 100ms);
    const auto pause = rule.resume_at() - kStart;
    EXPECT_GE(pause, 100ms);
    EXPECT_LT(pause, 150ms);
    seen.insert(pause);
  }
  EXPECT_GT(seen.size(), 190u) << "those who stopped together do not start together";
  EXPECT_LT(*seen.begin(), 110ms);
  EXPECT_GT(*seen.rbegin(), 140ms);
}

TEST(BusyRule, OneSeedIsOnePause) {
  BusyRule one(7), same(7);
  one.receive(kStart, 20ms);
  same.receive(kStart, 20ms);
  EXPECT_EQ(one.resume_at(), same.resume_at());
}

TEST(BusyRule, AnotherBusyProlongsOnlyIfItsTimeIsLonger) {
  BusyRule rule(1);
  rule.receive(kStart, 1s);
  const auto first = rule.resume_at();
  rule.receive(kStart + 100ms, 100ms);
  EXPECT_EQ(rule.resume_at(), first);
  rule.receive(kStart + 200ms, 2s);
  EXPECT_GE(rule.resume_at(), kStart + 2200ms);
}

TEST(BusyRule, BusiesCountWhenTheyAreMoreThanTenMillisecondsApart) {
  BusyRule rule(1);
  rule.receive(kStart, 1s);
  EXPECT_EQ(rule.level(kStart), 1u);
  rule.receive(kStart + 10ms, 100ms);
  EXPECT_EQ(rule.level(kStart + 10ms), 1u);
  rule.receive(kStart + 11ms, 100ms);
  EXPECT_EQ(rule.level(kStart + 11ms), 2u);
  rule.receive(kStart + 22ms, 100ms);
  EXPECT_EQ(rule.level(kStart + 22ms), 3u);
}

TEST(BusyRule, TheRandomPartGrowsWithTheCount) {
  Duration longest{};
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    BusyRule rule(seed);
    for (int i = 0; i < 10; ++i) rule.receive(kStart + i * 20ms, 10s);
    const auto part = rule.resume_at() - (kStart + 180ms) - 10s;
    EXPECT_LT(part, 500ms);
    longest = std::max(longest, part);
  }
  EXPECT_GT(longest, 250ms);
}

TEST(BusyRule, AfterThePauseItIsSlowAndThenForgets) {
  BusyRule rule(3);
  for (int i = 0; i < 3; ++i) rule.receive(kStart + i * 20ms, 1s);
  const auto resume = rule.resume_at();
  EXPECT_TRUE(rule.slow(resume));
  EXPECT_TRUE(rule.slow(resume + 299ms));
  EXPECT_EQ(rule.level(resume + 299ms), 3u);
  EXPECT_FALSE(rule.slow(resume + 300ms));
  EXPECT_EQ(rule.level(resume + 304ms), 3u);
  EXPECT_EQ(rule.level(resume + 305ms), 2u);
  EXPECT_EQ(rule.level(resume + 310ms), 1u);
  EXPECT_EQ(rule.level(resume + 315ms), 0u);
  EXPECT_EQ(rule.level(resume + 1h), 0u);
}

TEST(BusyRule, AFloodOfBusiesDoesNotStopSendingForEver) {
  BusyRule rule(3);
  for (int i = 0; i < 100000; ++i) rule.receive(kStart + i * 11ms, 0ms);
  EXPECT_EQ(rule.level(kStart + 100000 * 11ms), BusyRule::kMaxLevel);
  EXPECT_LT(rule.resume_at(), kStart + 100000 * 11ms + 5s);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
