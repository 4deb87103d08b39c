#include "gateway/gateway_tuple.h"

#include <gtest/gtest.h>

namespace rubicon::gateway {
namespace {

constexpr IslandId kOne{1}, kTwo{2};
const Address kHere{IslandId{9}, {}, {}};

TEST(SeenMessages, KnowsEachNumberOfEachOrigin) {
  SeenMessages seen;
  EXPECT_FALSE(seen.seen(kHere, kOne, 7));
  seen.note(kHere, kOne, 7);
  EXPECT_TRUE(seen.seen(kHere, kOne, 7));
  EXPECT_FALSE(seen.seen(kHere, kOne, 6));
  EXPECT_FALSE(seen.seen(kHere, kTwo, 7));
}

TEST(SeenMessages, KnowsANumberForItsDestinationOnly) {
  SeenMessages seen;
  seen.note({IslandId{9}, "wsn-1", "7"}, kOne, 7);
  EXPECT_TRUE(seen.seen({IslandId{9}, "wsn-1", "7"}, kOne, 7));
  for (const Address& other : {Address{IslandId{9}, "wsn-1", "8"},
                               {IslandId{9}, "wsn-1", ""},
                               {IslandId{9}, "", "7"},
                               {IslandId{8}, "wsn-1", "7"},
                               {IslandId{9}, "wsn-", "17"},
                               kHere})
    EXPECT_FALSE(seen.seen(other, kOne, 7)) << to_string(other);
}

TEST(SeenMessages, ForgetsTheOldestNumbersFirst) {
  SeenMessages seen;
  for (std::uint64_t i = 0; i <= SeenMessages::kNumbers; ++i) seen.note(kHere, kOne, 1000 + i);
  EXPECT_FALSE(seen.seen(kHere, kOne, 1000));
  EXPECT_TRUE(seen.seen(kHere, kOne, 1001));
  EXPECT_TRUE(seen.seen(kHere, kOne, 1000 + SeenMessages::kNumbers));
}

TEST(SeenMessages, ForgetsNumbersInTheOrderInWhichTheyCame) {
  SeenMessages seen;
  constexpr std::uint64_t kBeyond = 5;
  for (std::uint64_t i = 0; i < SeenMessages::kNumbers + kBeyond; ++i) seen.note(kHere, kOne, 1000 + i);
  for (std::uint64_t i = 0; i < SeenMessages::kNumbers + kBeyond; ++i) {
    EXPECT_EQ(seen.seen(kHere, kOne, 1000 + i), i >= kBeyond) << i;
  }
}

TEST(SeenMessages, ForgetsTheOriginsNotHeardForLongest) {
  SeenMessages seen;
  for (std::uint32_t i = 1; i <= SeenMessages::kOrigins; ++i) seen.note(kHere, IslandId{i}, 5);
  seen.note(kHere, kOne, 6);
  seen.note(kHere, IslandId{60000}, 5);
  EXPECT_TRUE(seen.seen(kHere, kOne, 5));
  EXPECT_FALSE(seen.seen(kHere, kTwo, 5));
  EXPECT_TRUE(seen.seen(kHere, IslandId{3}, 5));
}

}  // namespace
}  // namespace rubicon::gateway
