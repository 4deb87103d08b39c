#include "transport/asio_scheduler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace rubicon::transport {
namespace {

using namespace std::chrono_literals;

class AsioLoop : public ::testing::Test {
 protected:
  void note(const std::string& what) { order += what; }
  Loop loop;
  AsioScheduler& scheduler = loop.scheduler();
  std::string order;
};

TEST_F(AsioLoop, RunsPostsInOrderAndNeverFromInsidePost) {
  scheduler.post([&] {
    note("a");
    scheduler.post([&] {
      note("c");
      loop.stop();
    });
    note("b");
  });
  note("-");
  loop.run();
  EXPECT_EQ(order, "-abc");
}

TEST_F(AsioLoop, RunsTimersByTimeAndEqualTimesInTheOrderAskedFor) {
  const auto when = scheduler.now() + 10ms;
  auto last = scheduler.at(when + 5ms, [&] {
    note("3");
    loop.stop();
  });
  auto first = scheduler.at(when, [&] { note("1"); });
  auto second = scheduler.at(when, [&] { note("2"); });
  loop.run();
  EXPECT_EQ(order, "123");
}

TEST_F(AsioLoop, TimersDoNotRunBeforeTheirTime) {
  const auto asked = scheduler.now();
  SteadyTime ran{};
  auto timer = scheduler.after(20ms, [&] {
    ran = scheduler.now();
    loop.stop();
  });
  loop.run();
  EXPECT_GE(ran - asked, 20ms);
}

TEST_F(AsioLoop, ACancelledTimerDoesNotRun) {
  auto gone = scheduler.after(1ms, [&] { note("x"); });
  auto end = scheduler.after(10ms, [&] { loop.stop(); });
  gone.cancel();
  loop.run();
  EXPECT_EQ(order, "");
}

TEST_F(AsioLoop, AnEarlierTimerAskedForLaterStillComesFirst) {
  auto late = scheduler.after(40ms, [&] {
    note("late");
    loop.stop();
  });
  Timer early;
  scheduler.post([&] { early = scheduler.after(1ms, [&] { note("early "); }); });
  loop.run();
  EXPECT_EQ(order, "early late");
}

TEST_F(AsioLoop, PostsOfATimerRunBeforeTheNextTimer) {
  const auto when = scheduler.now() + 5ms;
  auto first = scheduler.at(when, [&] {
    note("1");
    scheduler.post([&] { note("posted"); });
  });
  auto second = scheduler.at(when, [&] {
    note("2");
    loop.stop();
  });
  loop.run();
  EXPECT_EQ(order, "1posted2");
}

/// Work that posts its next turn itself, beside many timers that are due.
class LongWork : public AsioLoop {
 protected:
  void SetUp() override {
    scheduler.post(next_turn);
    for (int i = 0; i < 50; ++i) {
      timers.push_back(scheduler.at(scheduler.now(), [this, i] {
        at_timer(i);
        EXPECT_EQ(timers_run++, i);
        if (timers_run == 50) loop.stop();
      }));
    }
  }

  std::function<void(int)> at_timer;
  int turns = 0, timers_run = 0;
  std::function<void()> next_turn = [this] {
    if (++turns < 100) scheduler.post(next_turn);
  };
  std::vector<Timer> timers;
};

TEST_F(LongWork, DoesNotHoldUpTimersThatPostNothing) {
  at_timer = [](int) {};
  loop.run();
  EXPECT_LT(turns, 5);
}

TEST_F(LongWork, DoesNotHoldUpSocketsWhileEachTimerPosts) {
  int turns_before_others = 1000;
  at_timer = [&](int i) {
    if (i == 0) boost::asio::post(loop.context(), [&] { turns_before_others = turns; });
    scheduler.post([] {});
  };
  loop.run();
  EXPECT_LT(turns_before_others, 5);
}

TEST_F(AsioLoop, CallsOfOtherThreadsThatPostDoNotHoldUpSockets) {
  int turns = 0, calls_run = 0, calls_before_others = 1000;
  std::function<void()> next_turn = [&] {
    if (++turns < 100) scheduler.post(next_turn);
  };
  std::vector<int> order;
  std::thread other([&] {
    for (int i = 0; i < 50; ++i) {
      scheduler.post([&, i] {
        if (i == 0) boost::asio::post(loop.context(), [&] { calls_before_others = calls_run; });
        scheduler.post([] {});
        order.push_back(i);
        if (++calls_run == 50) loop.stop();
      });
    }
  });
  other.join();
  scheduler.post(next_turn);
  loop.run();
  EXPECT_LT(calls_before_others, 5);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  EXPECT_EQ(order.size(), 50U);
}

TEST_F(AsioLoop, TakesPostsFromOtherThreadsAndRunsThemOnItsOwn) {
  bool on_loop = false, other_is_on_loop = true;
  std::thread other([&] {
    other_is_on_loop = scheduler.on_loop_thread();
    scheduler.post([&] {
      on_loop = scheduler.on_loop_thread();
      loop.stop();
    });
  });
  loop.run();
  other.join();
  EXPECT_TRUE(on_loop);
  EXPECT_FALSE(other_is_on_loop);
}

TEST_F(AsioLoop, TakesManyPostsOfSeveralThreadsEachInItsOrder) {
  constexpr int kThreads = 3, kPosts = 2000;
  std::vector<int> last(kThreads, 0);
  int ran = 0, out_of_order = 0;
  std::vector<std::thread> others;
  for (std::size_t thread = 0; thread < kThreads; ++thread) {
    others.emplace_back([&, thread] {
      for (int i = 1; i <= kPosts; ++i) {
        scheduler.post([&, thread, i] {
          out_of_order += std::exchange(last[thread], i) != i - 1;
          if (++ran == kThreads * kPosts) loop.stop();
        });
      }
    });
  }
  loop.run();
  for (auto& other : others) other.join();
  EXPECT_EQ(ran, kThreads * kPosts);
  EXPECT_EQ(out_of_order, 0);
}

TEST_F(AsioLoop, WhatACallFromAnotherThreadPostsRunsAfterItAndBeforeTheNextSuchCall) {
  scheduler.adopt_thread();
  std::thread other([&] {
    scheduler.post([&] {
      note("1");
      scheduler.post([&] { note("posted"); });
      note("-");
    });
    scheduler.post([&] {
      note("2");
      loop.stop();
    });
  });
  other.join();
  loop.run();
  EXPECT_EQ(order, "1-posted2");
}

TEST_F(AsioLoop, APostThatPostsForEverDoesNotStarveTimers) {
  std::function<void()> again = [&] { scheduler.post(again); };
  scheduler.post(again);
  auto end = scheduler.after(5ms, [&] { loop.stop(); });
  loop.run();
  SUCCEED();
}

TEST(AsioScheduler, PostsOfOtherThreadsThatDidNotRunDieWithIt) {
  const auto token = std::make_shared<int>(0);
  {
    Loop loop;
    std::thread([&] { loop.scheduler().post([token] { FAIL(); }); }).join();
  }
  EXPECT_EQ(token.use_count(), 1);
}

TEST(AsioScheduler, TimersMayOutliveIt) {
  Timer timer;
  {
    Loop loop;
    timer = loop.scheduler().after(1h, [] { FAIL(); });
  }
  timer.cancel();
  EXPECT_FALSE(timer.pending());
}

}  // namespace
}  // namespace rubicon::transport
