#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>

#include "tuples/peis/deliveries.h"
#include "tuples/peis/own_messages.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;

TEST(PeisHello, ItReadsWhatItWrites) {
  const Hello hello{1, 2500ms, 0x0102030405060708, "f00d"};
  const auto bytes = encode(hello);
  EXPECT_EQ(base::to_hex(bytes),
            "524243310001000009c40102030405060708"
            "66303064");
  EXPECT_EQ(decode_hello(bytes), hello);
}

TEST(PeisHello, WhatIsNoneIsRefused) {
  auto bytes = encode(Hello{});
  EXPECT_TRUE(decode_hello(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(decode_hello(ByteView(bytes).first(size)));
  auto version = bytes;
  version[5] = 0;
  EXPECT_FALSE(decode_hello(version));
  bytes[0] = 'X';
  EXPECT_EQ(decode_hello(bytes).error().code, ErrorCode::kInvalid);
}

TEST(PeisHello, ALeaseOutOfRangeIsTheNearestOneAndAHostIdIsCut) {
  const auto lease = [](Duration given) { return decode_hello(encode(Hello{1, given, 0, {}}))->lease; };
  EXPECT_EQ(lease(1ms), 500ms);
  EXPECT_EQ(lease(1h), 60s);
  const auto cut = decode_hello(encode(Hello{1, 2s, 0, std::string(100, 'h')}));
  EXPECT_EQ(cut->host_id.size(), Hello::kMaxHostId);
  auto later = encode(Hello{2, 2s, 0, "host"});
  for (const char c : {'\0', 'm', 'o', 'r', 'e'}) later.push_back(static_cast<std::uint8_t>(c));
  EXPECT_EQ(decode_hello(later)->host_id, "host") << "later versions append";
}

TEST(PeisSeenIds, TheLastOnesAreKnownAndTheOldestIsForgotten) {
  SeenIds<std::uint64_t> seen(3);
  for (const auto id : {1u, 2u, 3u}) EXPECT_TRUE(seen.add(id));
  for (const auto id : {1u, 2u, 3u}) EXPECT_FALSE(seen.add(id));
  EXPECT_TRUE(seen.add(4));
  EXPECT_TRUE(seen.add(1)) << "forgotten";
  EXPECT_FALSE(seen.add(3));
  EXPECT_EQ(seen.size(), 3u);
}

TEST(PeisSeenIds, IdsOfPackagesAreKnownUpToTheGreatest) {
  constexpr std::size_t kCapacity = 64;
  SeenIds<std::uint32_t> seen(kCapacity);
  for (const auto id : {0U, 1U, 0x7fffffffU, 0xfffffffeU}) {
    EXPECT_TRUE(seen.add(id));
    EXPECT_FALSE(seen.add(id)) << id;
  }
  for (std::uint32_t id = 100; id < 100 + 2 * kCapacity; ++id) EXPECT_TRUE(seen.add(id));
  for (std::uint32_t id = 100; id < 100 + kCapacity; ++id) EXPECT_FALSE(seen.contains(id)) << id;
  for (std::uint32_t id = 100 + kCapacity; id < 100 + 2 * kCapacity; ++id) EXPECT_TRUE(seen.contains(id)) << id;
  EXPECT_EQ(seen.size(), kCapacity);
}

TEST(PeisSeenIds, WidenedItForgetsNothingAndThenTheOldestFirst) {
  SeenIds<std::uint64_t> seen(3);
  for (const auto id : {1u, 2u, 3u, 4u}) seen.add(id);
  seen.widen(5);
  for (const auto id : {5u, 6u, 7u}) EXPECT_TRUE(seen.add(id));
  for (const auto id : {3u, 4u, 5u, 6u, 7u}) EXPECT_FALSE(seen.add(id));
  EXPECT_TRUE(seen.add(2)) << "forgotten";
}

TEST(PeisSeenIds, AnyIdsInAnyOrderAreKnownAsLongAsTheyAreAmongTheLast) {
  constexpr std::size_t kCapacity = 100;
  SeenIds<std::uint64_t> seen(kCapacity);
  std::deque<std::uint64_t> last;
  std::mt19937_64 random(1);
  for (int i = 0; i < 20'000; ++i) {
    const auto id = i % 3 == 0 ? random() >> 1 : random() % 150;
    const bool is_new = std::find(last.begin(), last.end(), id) == last.end();
    ASSERT_EQ(seen.contains(id), !is_new) << i;
    ASSERT_EQ(seen.add(id), is_new) << i;
    if (is_new) last.push_back(id);
    if (last.size() > kCapacity) last.pop_front();
  }
  for (const auto id : last) EXPECT_TRUE(seen.contains(id));
}

}  // namespace
}  // namespace rubicon::tuples::peis
