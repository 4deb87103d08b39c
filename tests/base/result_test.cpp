#include "rubicon/result.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <memory>
#include <set>

#include "base/log.h"
#include "rubicon/time.hpp"

namespace rubicon::base {
namespace {

using namespace std::chrono_literals;

Result<int> half_of(int number) {
  if (number % 2 != 0) return fail(ErrorCode::kInvalid, "odd");
  return number / 2;
}

Result<void> quarter_of(int number, int& out) {
  const auto half = half_of(number);
  if (!half) return fail(half.error());
  const auto quarter = half_of(*half);
  if (!quarter) return fail(quarter.error());
  out = *quarter;
  return {};
}

TEST(Result, HoldsAValueOrAnError) {
  EXPECT_EQ(*half_of(4), 2);
  EXPECT_EQ(half_of(3).error(), (Error{ErrorCode::kInvalid, "odd"}));
}

TEST(Result, PassesAnErrorOn) {
  int out = 0;
  EXPECT_TRUE(quarter_of(8, out));
  EXPECT_EQ(out, 2);
  EXPECT_EQ(quarter_of(6, out).error().text, "odd");
}

TEST(Result, HoldsWhatCanOnlyBeMoved) {
  Result<std::unique_ptr<int>> made = std::make_unique<int>(5);
  const auto taken = std::move(*made);
  EXPECT_EQ(*taken, 5);
}

TEST(ErrorCode, EachHasAWordOfItsOwn) {
  std::set<std::string_view> words;
  for (int i = 0; i <= static_cast<int>(ErrorCode::kIo); ++i) words.insert(to_string(static_cast<ErrorCode>(i)));
  EXPECT_EQ(words, (std::set<std::string_view>{"invalid", "not-found", "out-of-range", "unsupported", "refused", "busy",
                                               "expired", "duplicate", "unreachable", "io"}));
}

TEST(WallTime, IsSecondsWithAFraction) {
  EXPECT_EQ(to_seconds(WallTime(1'700'000'000'250'000us)), 1'700'000'000.25);
  EXPECT_EQ(to_seconds(WallTime{}), 0);
}

TEST(RateLimit, AllowsASubjectOnceAPeriod) {
  RateLimit limit;
  const SteadyTime start(1h);
  EXPECT_TRUE(limit.allow("mote 7", start));
  EXPECT_FALSE(limit.allow("mote 7", start + 59s));
  EXPECT_TRUE(limit.allow("mote 7", start + 60s));
  EXPECT_FALSE(limit.allow("mote 7", start + 61s));
  EXPECT_EQ(limit.swallowed(), 2U);
}

TEST(RateLimit, CountsEachSubjectForItself) {
  RateLimit limit(1s);
  EXPECT_TRUE(limit.allow("a", SteadyTime(1h)));
  EXPECT_TRUE(limit.allow("b", SteadyTime(1h)));
  EXPECT_FALSE(limit.allow("a", SteadyTime(1h)));
  EXPECT_EQ(limit.swallowed(), 1U);
}

TEST(RateLimit, NewcomersBeyondTheBoundShareOneBudget) {
  RateLimit limit;
  const SteadyTime now(1h);
  for (int i = 0; i < 1024; ++i) EXPECT_TRUE(limit.allow(std::to_string(i), now));
  EXPECT_TRUE(limit.allow("first newcomer", now));
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(limit.allow("newcomer " + std::to_string(i), now));
  EXPECT_EQ(limit.swallowed(), 1000U);
  EXPECT_TRUE(limit.allow("0", now + 60s));
  EXPECT_TRUE(limit.allow("newcomer 1", now + 60s));
}

TEST(RateLimit, LongSubjectsAreTakenApartAndTakeNoMoreMemoryThanOthers) {
  RateLimit limit;
  const SteadyTime now(1h);
  const std::string topic(60'000, 'x');
  const auto before = ::mallinfo2().uordblks;
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(limit.allow(topic + std::to_string(i), now));
  EXPECT_LT(::mallinfo2().uordblks, before + 1'000'000);
  EXPECT_FALSE(limit.allow(topic + "0", now));
}

TEST(RateLimit, OldSubjectsMakeRoomForNewOnes) {
  RateLimit limit;
  const SteadyTime now(1h);
  for (int i = 0; i < 1024; ++i) EXPECT_TRUE(limit.allow(std::to_string(i), now));
  EXPECT_TRUE(limit.allow("first newcomer", now + 61s));
  EXPECT_TRUE(limit.allow("second newcomer", now + 61s)) << "it shares no line with the first";
}

}  // namespace
}  // namespace rubicon::base
