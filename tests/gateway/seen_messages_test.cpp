#include "gateway/seen_messages.h"

#include <gtest/gtest.h>

namespace rubicon::gateway {
namespace {

constexpr IslandId kOne{1}, kTwo{2};

TEST(SeenMessages, KnowsEachNumberOfEachOrigin) {
  SeenMessages seen;
  EXPECT_FALSE(seen.seen(kOne, 7));
  seen.note(kOne, 7);
  EXPECT_TRUE(seen.seen(kOne, 7));
  EXPECT_FALSE(seen.seen(kOne, 6));
  EXPECT_FALSE(seen.seen(kTwo, 7));
}

TEST(SeenMessages, ForgetsTheOldestNumbersFirst) {
  SeenMessages seen;
  for (std::uint64_t i = 0; i <= SeenMessages::kNumbers; ++i) seen.note(kOne, 1000 + i);
  EXPECT_FALSE(seen.seen(kOne, 1000));
  EXPECT_TRUE(seen.seen(kOne, 1001));
  EXPECT_TRUE(seen.seen(kOne, 1000 + SeenMessages::kNumbers));
}

TEST(SeenMessages, ForgetsNumbersInTheOrderInWhichTheyCame) {
  SeenMessages seen;
  constexpr std::uint64_t kBeyond = 5;
  for (std::uint64_t i = 0; i < SeenMessages::kNumbers + kBeyond; ++i) seen.note(kOne, 1000 + i);
  for (std::uint64_t i = 0; i < SeenMessages::kNumbers + kBeyond; ++i) {
    EXPECT_EQ(seen.seen(kOne, 1000 + i), i >= kBeyond) << i;
  }
}

TEST(SeenMessages, ForgetsTheOriginsNotHeardForLongest) {
  SeenMessages seen;
  for (std::uint32_t i = 1; i <= SeenMessages::kOrigins; ++i) seen.note(IslandId{i}, 5);
  seen.note(kOne, 6);
  seen.note(IslandId{60000}, 5);
  EXPECT_TRUE(seen.seen(kOne, 5));
  EXPECT_FALSE(seen.seen(kTwo, 5));
  EXPECT_TRUE(seen.seen(IslandId{3}, 5));
}

}  // namespace
}  // namespace rubicon::gateway
