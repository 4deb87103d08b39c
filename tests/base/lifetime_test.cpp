#include "base/scheduler.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "base/expiring_queues.h"
#include "base/log.h"
#include "base/virtual_scheduler.h"

namespace rubicon::base {
namespace {

using std::chrono::milliseconds;

TEST(LifetimeOfAnOwner, PostedCallsHappenOnlyWhileItLives) {
  VirtualScheduler scheduler;
  int calls = 0;
  auto living = std::make_unique<Lifetime>(), ending = std::make_unique<Lifetime>();
  living->post(scheduler, [&] { ++calls; });
  ending->post(scheduler, [&] { calls += 100; });
  ending.reset();
  scheduler.run_for(milliseconds(1));
  EXPECT_EQ(calls, 1);
}

TEST(LifetimeOfAnOwner, GuardedCallsPassTheirArgumentsOn) {
  std::string got;
  auto lifetime = std::make_unique<Lifetime>();
  const std::function<void(std::string, int)> call =
      lifetime->guard([&](std::string text, int number) { got = text + std::to_string(number); });
  call("a", 1);
  EXPECT_EQ(got, "a1");
  lifetime.reset();
  call("b", 2);
  EXPECT_EQ(got, "a1");
}

TEST(LifetimeOfAnOwner, ACallSeesThatItDestroyedTheOwner) {
  auto lifetime = std::make_unique<Lifetime>();
  const auto watch = lifetime->watch();
  EXPECT_FALSE(watch.ended());
  lifetime.reset();
  EXPECT_TRUE(watch.ended());
  Lifetime early;
  early.end();
  EXPECT_TRUE(early.watch().ended());
}

TEST(CallsOncePerTurn, ManyRequestsOfATurnBecomeOneCall) {
  VirtualScheduler scheduler;
  int calls = 0;
  OncePerTurn once(scheduler, [&] {
    if (++calls == 2) once.request();
  });
  for (int i = 0; i < 5; ++i) once.request();
  EXPECT_EQ(calls, 0);
  scheduler.run_for(milliseconds(1));
  EXPECT_EQ(calls, 1);
  once.request();
  scheduler.run_for(milliseconds(1));
  EXPECT_EQ(calls, 3);  // the second call asked for another one
}

TEST(CallsOncePerTurn, ADestroyedOneCallsNobody) {
  VirtualScheduler scheduler;
  int calls = 0;
  auto once = std::make_unique<OncePerTurn>(scheduler, [&] { ++calls; });
  once->request();
  once.reset();
  scheduler.run_for(milliseconds(1));
  EXPECT_EQ(calls, 0);
  once = std::make_unique<OncePerTurn>(scheduler, [&] { once.reset(), ++calls; });
  once->request();
  scheduler.run_for(milliseconds(1));
  EXPECT_EQ(calls, 1);
}

TEST(DeadlineOfMany, IsTheEarliest) {
  VirtualScheduler scheduler;
  std::vector<milliseconds> reached;
  const auto start = scheduler.now();
  Deadline deadline(scheduler,
                    [&] { reached.push_back(std::chrono::duration_cast<milliseconds>(scheduler.now() - start)); });
  deadline.advance_to(start + milliseconds(50));
  deadline.advance_to(start + milliseconds(20));
  deadline.advance_to(start + milliseconds(30));
  scheduler.run_for(milliseconds(100));
  EXPECT_EQ(reached, std::vector{milliseconds(20)});
  deadline.set(milliseconds(10));
  deadline.set(milliseconds(40));
  scheduler.run_for(milliseconds(100));
  EXPECT_EQ(reached.back(), milliseconds(140));
  EXPECT_EQ(reached.size(), 2U);
}

TEST(DeadlineOfMany, MayBeDestroyedInItsCall) {
  VirtualScheduler scheduler;
  std::string reached;
  std::unique_ptr<Deadline> deadline;
  // The text makes the call too large to be stored inside the std::function.
  deadline = std::make_unique<Deadline>(scheduler, [&, text = std::string("longer than the text of a small string")] {
    deadline.reset();
    reached = text;
  });
  deadline->set(milliseconds(5));
  scheduler.run_for(milliseconds(10));
  EXPECT_EQ(reached, "longer than the text of a small string");
  EXPECT_EQ(deadline, nullptr);
}

TEST(DeadlineOfMany, ClearedItDoesNotCallAndCanBeSetAgain) {
  VirtualScheduler scheduler;
  int calls = 0;
  Deadline deadline(scheduler, [&] { ++calls; });
  deadline.set(milliseconds(10));
  deadline.clear();
  EXPECT_FALSE(deadline.is_set());
  scheduler.run_for(milliseconds(5));
  deadline.advance_to(scheduler.now() + milliseconds(20));
  scheduler.run_for(milliseconds(19));
  EXPECT_EQ(calls, 0);
  scheduler.run_for(milliseconds(1));
  EXPECT_EQ(calls, 1);
}

struct Item {
  int number;
  SteadyTime expires;
};

TEST(QueuesOfWhatExpires, GiveBackWhatWaitedTooLongAndKeepTheOrderOfTheRest) {
  VirtualScheduler scheduler;
  std::vector<int> expired;
  int swept = 0;
  ExpiringQueues<Item> queues(
      scheduler, 2, [&](Item item) { expired.push_back(item.number); }, [&] { ++swept; });
  const auto now = scheduler.now();
  queues.push_back(0, {1, now + milliseconds(50)});
  queues.push_back(0, {2, now + milliseconds(20)});
  queues.push_back(0, {3, SteadyTime::max()});
  queues.push_front(0, {0, now + milliseconds(500)});
  queues.push_back(1, {4, now + milliseconds(21)});
  scheduler.run_for(milliseconds(20));
  EXPECT_EQ(expired, std::vector{2});
  scheduler.run_for(milliseconds(80));
  EXPECT_EQ(expired, (std::vector{2, 4, 1}));
  EXPECT_EQ(swept, 3);
  EXPECT_EQ(queues.size(0), 2U);
  EXPECT_TRUE(queues.empty(1));
  EXPECT_EQ(queues.pop_front(0).number, 0);
  EXPECT_EQ(queues.pop_front(0).number, 3);
}

TEST(QueuesOfWhatExpires, TakeNewItemsWhileOthersExpire) {
  VirtualScheduler scheduler;
  std::vector<int> expired;
  std::unique_ptr<ExpiringQueues<Item>> queues;
  queues = std::make_unique<ExpiringQueues<Item>>(scheduler, 1, [&](const Item& item) {
    expired.push_back(item.number);
    if (item.number < 10) queues->push_back(0, {item.number + 10, scheduler.now() + milliseconds(2)});
  });
  queues->push_back(0, {1, scheduler.now()});
  queues->push_back(0, {2, scheduler.now() + milliseconds(1)});
  scheduler.run_for(milliseconds(1));
  EXPECT_EQ(expired, std::vector{1});
  scheduler.run_for(milliseconds(100));
  EXPECT_EQ(expired, (std::vector{1, 2, 11, 12}));
  EXPECT_TRUE(queues->empty(0));
}

TEST(QueuesOfWhatExpires, DestroyedTheyGiveNothingBack) {
  VirtualScheduler scheduler;
  int expired = 0;
  auto queues = std::make_unique<ExpiringQueues<Item>>(scheduler, 1, [&](const Item&) { ++expired; });
  queues->push_back(0, {1, scheduler.now() + milliseconds(1)});
  queues.reset();
  scheduler.run_for(milliseconds(100));
  EXPECT_EQ(expired, 0);
}

class Lines final : public LogSink {
 public:
  void write(LogLevel, std::string_view, std::string_view text) override { lines.emplace_back(text); }
  std::vector<std::string> lines;
};

TEST(LogOfWhatHappensOften, HasOneLineASubjectAndMinute) {
  VirtualScheduler scheduler;
  Lines lines;
  LimitedLog log(Log(lines, "wsn"), scheduler);
  EXPECT_TRUE(log.warning("mote 1", "a"));
  EXPECT_FALSE(log.warning("mote 1", "b"));
  EXPECT_TRUE(log.info("mote 2", "c"));
  scheduler.run_for(std::chrono::seconds(61));
  log.warning("mote 1", "d");
  EXPECT_EQ(lines.lines, (std::vector<std::string>{"a", "c", "d"}));
}

}  // namespace
}  // namespace rubicon::base
