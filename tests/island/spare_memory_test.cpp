#include "island/spare_memory.h"

#include <gtest/gtest.h>

#include <vector>

#include "base/virtual_scheduler.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;

TEST(SpareMemory, IsGivenBackWhenItGrewAndNotOften) {
  constexpr std::size_t kMegabyte = 1 << 20;
  VirtualScheduler time;
  std::size_t resident = 20 * kMegabyte, left = 20 * kMegabyte;
  int given = 0;
  const auto give = [&] {
    ++given;
    resident = left;
  };
  const SpareMemory spare(time, give, [&] { return resident; });
  time.run_for(1h);
  EXPECT_EQ(given, 0) << "it is as large as it was";
  resident = 22 * kMegabyte;
  time.run_for(1h);
  EXPECT_EQ(given, 0) << "too little to be worth it";
  resident = 23 * kMegabyte;
  time.run_for(SpareMemory::kPeriod);
  EXPECT_EQ(given, 1);
  resident = left = 40 * kMegabyte;  // that is needed
  time.run_for(1h);
  EXPECT_EQ(given, 2) << "asked once";
  resident = left = 10 * kMegabyte;
  time.run_for(SpareMemory::kPeriod);
  resident = 13 * kMegabyte;
  time.run_for(SpareMemory::kPeriod);
  EXPECT_EQ(given, 3) << "it grew from the least that it was";
  resident = left = 1000 * kMegabyte;
  time.run_for(SpareMemory::kPeriod);
  resident = 1060 * kMegabyte;
  time.run_for(1h);
  EXPECT_EQ(given, 4) << "less than a sixteenth";
}

TEST(SpareMemory, OfThisProcessIsKnown) {
  const auto before = resident_memory();
  EXPECT_GT(before, 0U);
  const std::vector<char> touched(64 << 20, 1);
  EXPECT_GT(resident_memory(), before + (60 << 20)) << touched.size();
}

}  // namespace
}  // namespace rubicon::island
