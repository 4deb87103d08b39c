#include "island/spare_memory.h"

#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;

TEST(SpareMemory, IsGivenBackAfterManyLeftAndNotOften) {
  VirtualScheduler time;
  tuples::MemoryEcology ecology(time);
  const auto link = std::move(*ecology.join(OwnerId(1)));
  tuples::TupleSpace space(OwnerId(1), time, *link);
  int given = 0;
  const SpareMemory spare(time, space, [&] { ++given; });
  const auto come_and_go = [&](int visitors) {
    for (int i = 0; i < visitors; ++i) {
      const auto visit = std::move(*ecology.join(OwnerId(70000)));
      const tuples::TupleSpace visitor(OwnerId(70000), time, *visit);
      time.run_for(1ms);
    }
    time.run_for(1ms);
  };
  come_and_go(SpareMemory::kMany - 1);
  EXPECT_EQ(given, 0);
  come_and_go(1);
  EXPECT_EQ(given, 1);
  come_and_go(10 * SpareMemory::kMany);
  EXPECT_EQ(given, 1) << "a moment ago";
  time.run_for(SpareMemory::kPause);
  EXPECT_EQ(given, 2);
  time.run_for(1h);
  EXPECT_EQ(given, 2 + 1h / SpareMemory::kPeriod) << "of connections that ended, too";
}

}  // namespace
}  // namespace rubicon::island
