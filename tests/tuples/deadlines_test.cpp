#include <gtest/gtest.h>
#include <malloc.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;

/// Bytes in use, of large blocks too.
std::size_t in_use() {
  const auto heap = ::mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

/// What the heap of this process grows by in 90,000 sets of a tuple, one each 10 ms, after 10,000 of them.
struct SetAgain : TwoComponents {
  template <class Set>
  std::size_t growth(Set set) {
    std::size_t before = 0;
    for (int i = 0; i < 100'000; ++i) {
      EXPECT_TRUE(set(i));
      time.run_for(10ms);
      if (i == 10'000) before = in_use();
    }
    const auto now = in_use();
    return now - std::min(now, before);
  }
};
constexpr std::size_t kFew = 200'000;  ///< bytes; a deadline for each set takes 2 MB

struct ManyDeadlines : testing::Test, SetAgain {
  std::size_t seen = 0;
  EventCall count() {
    return [this](const Event&) { ++seen; };
  }
};

TEST_F(ManyDeadlines, OfACopyThatIsSetAgainOnlyTheLastStays) {
  const auto handle = robot->space.subscribe(pattern("*:a"), {}, count());
  EXPECT_LT(growth([&](int i) { return island->space.set("a", std::to_string(i), {.lifetime = 1h}); }), kFew);
  EXPECT_GE(seen, 100'000U);
  time.run_for(1h);
  EXPECT_FALSE(robot->space.get(kIsland, "a")) << "it has expired";
}

TEST_F(ManyDeadlines, OfATupleThatExpiresNowAndThenOnlyTheLastStays) {
  EXPECT_LT(growth([&](int i) {
              return island->space.set("a", std::to_string(i), {.lifetime = i % 2 == 0 ? Duration(1h) : Duration(0)});
            }),
            kFew);
  time.run_for(2h);
  EXPECT_TRUE(island->space.get(kIsland, "a")) << "the last set has no lifetime";
}

TEST_F(ManyDeadlines, OfAPacedSubscriptionOnlyTheNextStays) {
  const auto handle = island->space.subscribe(pattern("*:a"), {.minimum = 15ms, .maximum = 1h}, count());
  EXPECT_LT(growth([&](int i) { return island->space.set("a", std::to_string(i)); }), kFew);
  const auto before = seen;
  time.run_for(3h);
  EXPECT_GE(seen, before + 3) << "the maximum still holds";
}

}  // namespace
}  // namespace rubicon::tuples
