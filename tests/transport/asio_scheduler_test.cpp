#include "transport/asio_scheduler.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

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

TEST_F(AsioLoop, APostThatPostsForEverDoesNotStarveTimers) {
  std::function<void()> again = [&] { scheduler.post(again); };
  scheduler.post(again);
  auto end = scheduler.after(5ms, [&] { loop.stop(); });
  loop.run();
  SUCCEED();
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
