#include "island/spare_memory.h"

#include <gtest/gtest.h>

#include <vector>

#include "base/virtual_scheduler.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;

struct Heap : testing::Test {
  static constexpr std::size_t kMegabyte = 1 << 20;

  /// Looks once, and says whether memory was given back.
  bool look() {
    const auto before = given;
    time.run_for(SpareMemory::kPeriod);
    return given > before;
  }

  VirtualScheduler time;
  std::size_t resident = 20 * kMegabyte, left = 20 * kMegabyte;
  int given = 0;
  const SpareMemory spare{time,
                          [this] {
                            ++given;
                            resident = left;
                          },
                          [this] { return resident; }};
};

TEST_F(Heap, IsGivenBackAtTheNextLookAfterItGrew) {
  EXPECT_FALSE(look()) << "it is as large as it was";
  resident = 22 * kMegabyte;
  EXPECT_FALSE(look()) << "too little to be worth it";
  resident = 23 * kMegabyte;
  EXPECT_TRUE(look());
  resident = left = 40 * kMegabyte;  // that is needed
  EXPECT_TRUE(look());
  EXPECT_FALSE(look()) << "asked once";
  resident = left = 10 * kMegabyte;
  EXPECT_FALSE(look());
  resident = 13 * kMegabyte;
  EXPECT_TRUE(look()) << "it grew from the least that it was";
  resident = left = 1000 * kMegabyte;
  EXPECT_TRUE(look());
  resident = 1060 * kMegabyte;
  EXPECT_FALSE(look()) << "less than a sixteenth";
}

TEST_F(Heap, IsGivenBackOnceAMinuteBecauseWhatWasInUseMayBeFreeNow) {
  time.run_for(SpareMemory::kLooks * SpareMemory::kPeriod);
  EXPECT_EQ(given, 1);
  time.run_for(1h);
  EXPECT_EQ(given, 61);
}

TEST(ResidentMemory, IsThatOfThisProcess) {
  const auto before = resident_memory();
  EXPECT_GT(before, 0U);
  const std::vector<char> touched(64 << 20, 1);
  EXPECT_GT(resident_memory(), before + (60 << 20)) << touched.size();
}

}  // namespace
}  // namespace rubicon::island
