#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"

namespace rubicon::base {
namespace {

using namespace std::chrono_literals;

TEST(Scheduler, RunsTimersInTheOrderOfTheirTimes) {
  VirtualScheduler scheduler;
  std::string order;
  const auto late = scheduler.after(3s, [&] { order += 'c'; });
  const auto early = scheduler.after(1s, [&] { order += 'a'; });
  const auto middle = scheduler.after(2s, [&] { order += 'b'; });
  scheduler.run_for(2s);
  EXPECT_EQ(order, "ab");
  scheduler.run_for(1s);
  EXPECT_EQ(order, "abc");
}

TEST(Scheduler, RunsEqualTimesInTheOrderTheyWereAskedFor) {
  VirtualScheduler scheduler;
  std::vector<int> order;
  std::vector<Timer> timers;
  const auto when = scheduler.now() + 1s;
  for (int i = 0; i < 1000; ++i) timers.push_back(scheduler.at(when, [&order, i] { order.push_back(i); }));
  scheduler.run_for(1s);
  ASSERT_EQ(order.size(), 1000U);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(Scheduler, ATimerSeesItsOwnTime) {
  VirtualScheduler scheduler;
  const auto start = scheduler.now();
  const auto wall = scheduler.wall_now();
  SteadyTime seen{};
  WallTime seen_wall{};
  const auto timer = scheduler.after(1500ms, [&] {
    seen = scheduler.now();
    seen_wall = scheduler.wall_now();
  });
  scheduler.run_for(10s);
  EXPECT_EQ(seen - start, 1500ms);
  EXPECT_EQ(seen_wall - wall, 1500ms);
  EXPECT_EQ(scheduler.now() - start, 10s);
}

TEST(Scheduler, ATimeInThePastRunsInTheNextTurn) {
  VirtualScheduler scheduler;
  const auto start = scheduler.now();
  bool ran = false;
  const auto timer = scheduler.at(start - 1h, [&] { ran = true; });
  EXPECT_FALSE(ran);
  scheduler.run_ready();
  EXPECT_TRUE(ran);
  EXPECT_EQ(scheduler.now(), start);
}

TEST(Scheduler, PostsRunInOrderAndNeverFromInsidePost) {
  VirtualScheduler scheduler;
  std::string order;
  scheduler.post([&] {
    scheduler.post([&] { order += 'c'; });
    order += 'a';
  });
  scheduler.post([&] { order += 'b'; });
  EXPECT_EQ(order, "");
  scheduler.run_ready();
  EXPECT_EQ(order, "abc");
}

TEST(Scheduler, SmallStepsOfTheWallClockAddUp) {
  VirtualScheduler scheduler;
  const auto wall = scheduler.wall_now();
  for (int i = 0; i < 1000; ++i) scheduler.run_for(1ns);
  EXPECT_EQ(scheduler.wall_now() - wall, 1us);
}

TEST(Scheduler, SettingTheWallClockMovesNoTimer) {
  VirtualScheduler scheduler;
  bool ran = false;
  const auto timer = scheduler.after(1s, [&] { ran = true; });
  scheduler.set_wall(scheduler.wall_now() + 24h);
  scheduler.run_for(999ms);
  EXPECT_FALSE(ran);
  scheduler.run_for(1ms);
  EXPECT_TRUE(ran);
}

TEST(Timer, DoesNotRunOnceCancelled) {
  VirtualScheduler scheduler;
  bool ran = false;
  auto timer = scheduler.after(1s, [&] { ran = true; });
  EXPECT_TRUE(timer.pending());
  timer.cancel();
  timer.cancel();
  EXPECT_FALSE(timer.pending());
  scheduler.run_for(2s);
  EXPECT_FALSE(ran);
}

TEST(Timer, DoesNotRunOnceDestroyed) {
  VirtualScheduler scheduler;
  bool ran = false;
  {
    const auto timer = scheduler.after(1s, [&] { ran = true; });
  }
  scheduler.run_for(2s);
  EXPECT_FALSE(ran);
}

TEST(Timer, IsCancelledByTheNextOneAssignedToIt) {
  VirtualScheduler scheduler;
  std::string order;
  auto timer = scheduler.after(1s, [&] { order += 'a'; });
  timer = scheduler.after(2s, [&] { order += 'b'; });
  scheduler.run_for(3s);
  EXPECT_EQ(order, "b");
}

TEST(Timer, MovesWithItsCall) {
  VirtualScheduler scheduler;
  bool ran = false;
  auto first = scheduler.after(1s, [&] { ran = true; });
  const Timer second = std::move(first);
  EXPECT_TRUE(second.pending());
  scheduler.run_for(1s);
  EXPECT_TRUE(ran);
  EXPECT_FALSE(second.pending());
}

TEST(Timer, MayCancelAnotherOfTheSameTime) {
  VirtualScheduler scheduler;
  bool ran = false;
  Timer second;
  const auto first = scheduler.after(1s, [&] { second.cancel(); });
  second = scheduler.after(1s, [&] { ran = true; });
  scheduler.run_for(2s);
  EXPECT_FALSE(ran);
}

TEST(Timer, MayCancelItselfAndBeArmedAgainWhileItRuns) {
  VirtualScheduler scheduler;
  int runs = 0;
  Timer timer;
  std::function<void()> tick = [&] {
    EXPECT_FALSE(timer.pending());
    timer.cancel();
    if (++runs < 3) timer = scheduler.after(1s, tick);
  };
  timer = scheduler.after(1s, tick);
  scheduler.run_for(10s);
  EXPECT_EQ(runs, 3);
}

TEST(Timer, MayBeDestroyedWithItsOwnerWhileItRuns) {
  struct Owner {
    Timer timer;
    int touched = 0;
  };
  VirtualScheduler scheduler;
  auto owner = std::make_unique<Owner>();
  bool ran = false;
  owner->timer = scheduler.after(1s, [&] {
    owner.reset();
    ran = true;
  });
  scheduler.run_for(1s);
  EXPECT_TRUE(ran);
}

TEST(Timer, MayBeOwnedByItsOwnCall) {
  struct Owner {
    Timer timer;
  };
  VirtualScheduler scheduler;
  auto owner = std::make_shared<Owner>();
  const std::weak_ptr<Owner> alive = owner;
  owner->timer = scheduler.after(1s, [owner] {});
  auto& timer = owner->timer;
  owner.reset();
  ASSERT_FALSE(alive.expired());
  timer.cancel();
  EXPECT_TRUE(alive.expired());
}

TEST(Timer, MayOutliveItsScheduler) {
  auto scheduler = std::make_unique<VirtualScheduler>();
  bool ran = false;
  auto timer = scheduler->after(1s, [&] { ran = true; });
  scheduler.reset();
  timer.cancel();
  EXPECT_FALSE(timer.pending());
  EXPECT_FALSE(ran);
}

TEST(TimerHeap, StaysSmallWhenTimersAreArmedAgain) {
  TimerHeap heap;
  Timer timer;
  std::size_t largest = 0;
  for (int i = 0; i < 100'000; ++i) {
    timer = heap.add(SteadyTime(std::chrono::seconds(1'000'000 - i)), [] {});
    largest = std::max(largest, heap.size());
  }
  EXPECT_LE(largest, 1025U);
  EXPECT_EQ(heap.next(), SteadyTime(std::chrono::seconds(900'001)));
}

TEST(TimerHeap, KeepsTheLiveOnesWhenItSweeps) {
  TimerHeap heap;
  std::vector<Timer> live;
  for (int i = 0; i < 2000; ++i) live.push_back(heap.add(SteadyTime(std::chrono::seconds(i + 1)), [] {}));
  Timer rearmed;
  for (int i = 0; i < 100'000; ++i) rearmed = heap.add(SteadyTime(1h), [] {});
  rearmed.cancel();
  EXPECT_LE(heap.size(), 8192U);
  int taken = 0;
  while (heap.take_due(SteadyTime(2h))) ++taken;
  EXPECT_EQ(taken, 2000);
  EXPECT_EQ(heap.next(), std::nullopt);
}

TEST(TimerHeap, GivesNothingBeforeItsTime) {
  TimerHeap heap;
  const auto timer = heap.add(SteadyTime(1s), [] {});
  EXPECT_FALSE(heap.take_due(SteadyTime(1s) - 1ns));
  EXPECT_TRUE(timer.pending());
  EXPECT_TRUE(heap.take_due(SteadyTime(1s)));
  EXPECT_FALSE(timer.pending());
  EXPECT_FALSE(heap.take_due(SteadyTime(1s)));
}

}  // namespace
}  // namespace rubicon::base
