#include "tuples/dds/catch_up.h"

#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "tuples/dds/early_sets.h"

namespace rubicon::tuples::dds {
namespace {

using namespace std::chrono_literals;

RemoteSet set_of(std::uint32_t from, std::uint64_t request, Duration time_to_live, std::size_t size = 1) {
  RemoteSet set;
  set.from = OwnerId(from);
  set.request = request;
  set.value.assign(size, '1');
  set.time_to_live = time_to_live;
  return set;
}

TEST(CatchUp, LastsAWhileAfterTheStartAndNotWhileTheProcessRuns) {
  base::VirtualScheduler scheduler;
  CatchUp catch_up(scheduler, 2s);
  EXPECT_EQ(catch_up.left(), Duration(CatchUp::kAfterStart));
  scheduler.run_for(CatchUp::kAfterStart);
  EXPECT_EQ(catch_up.left(), Duration(0));
  scheduler.run_for(1h);
  EXPECT_EQ(catch_up.left(), Duration(0));
}

TEST(CatchUp, LastsAWhileAfterTheProcessWasStopped) {
  base::VirtualScheduler scheduler;
  CatchUp catch_up(scheduler, 2s);
  scheduler.run_for(1min);
  scheduler.stop_for(900ms);
  EXPECT_EQ(catch_up.left(), Duration(0));
  scheduler.stop_for(1100ms);
  EXPECT_EQ(catch_up.left(), Duration(CatchUp::kAfterSleep)) << "before any timer ran";
  scheduler.run_for(CatchUp::kAfterSleep);
  EXPECT_EQ(catch_up.left(), Duration(0));
  scheduler.stop_for(3s);
  scheduler.run_for(500ms);
  EXPECT_EQ(catch_up.left(), Duration(CatchUp::kAfterSleep - 500ms)) << "a timer noticed";
}

TEST(CatchUp, LastsAWhileAfterTheHostSlept) {
  base::VirtualScheduler scheduler;
  CatchUp catch_up(scheduler, 2s);
  scheduler.run_for(1min);
  scheduler.set_wall(scheduler.wall_now() + 8h);
  EXPECT_EQ(catch_up.left(), Duration(CatchUp::kAfterSleep));
}

TEST(EarlySets, ComeInOrder) {
  EarlySets sets;
  for (std::uint64_t i = 1; i <= 3; ++i) EXPECT_TRUE(sets.add({set_of(i == 2 ? 2 : 1, i, 5s), {}, 7, {}, {}}));
  EXPECT_TRUE(sets.has(OwnerId(1)));
  EXPECT_FALSE(sets.has(OwnerId(3)));
  const auto taken = sets.take();
  ASSERT_EQ(taken.size(), 3U);
  for (std::uint64_t i = 1; i <= 3; ++i) EXPECT_EQ(taken[i - 1].set.request, i);
  EXPECT_TRUE(sets.empty());
  EXPECT_FALSE(sets.has(OwnerId(1)));
}

TEST(EarlySets, CountAllThatASetHas) {
  EarlySets sets;
  auto set = set_of(1, 1, 0s);
  set.media_type.assign(EarlySets::kMaxOfOne, 'a');
  EXPECT_FALSE(sets.add({set, {}, 7, {}, {}}));
}

TEST(CatchUp, LastsAWhileAfterTheProcessWasOutside) {
  base::VirtualScheduler scheduler;
  CatchUp catch_up(scheduler, 2s);
  scheduler.run_for(1min);
  catch_up.begin();
  EXPECT_EQ(catch_up.left(), Duration(CatchUp::kAfterStart));
}

TEST(EarlySets, OfOneComponentTakeNotTheRoomOfAnother) {
  EarlySets sets;
  std::uint64_t count = 0;
  while (count < 1000 && sets.add({set_of(1, count, 0s, 100'000), {}, 7, {}, {}})) ++count;
  EXPECT_EQ(count, EarlySets::kMaxOfOne / 100'000 - 1) << "with their numbers";
  EXPECT_FALSE(sets.add({set_of(1, count, 0s), {}, 7, {}, {}})) << "a small one does not overtake it";
  EXPECT_TRUE(sets.add({set_of(2, 1, 0s, 100'000), {}, 7, {}, {}}));
  EXPECT_EQ(sets.take().size(), count + 1);
  EXPECT_TRUE(sets.add({set_of(1, 1, 0s, 100'000), {}, 7, {}, {}})) << "the room is free again";
}

}  // namespace
}  // namespace rubicon::tuples::dds
