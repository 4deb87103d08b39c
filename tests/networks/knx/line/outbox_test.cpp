#include "networks/knx/line/telegram_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"

namespace rubicon::networks::knx::line {
namespace {

using namespace std::chrono_literals;

class OutboxTest : public testing::Test {
 protected:
  void make(TelegramQueue::Limits limits) {
    telegrams = std::make_unique<TelegramQueue>(time, limits, [this] {
      if (!auto_send) return;
      while (const auto* telegram = telegrams->take()) {
        taken.push_back(number(telegram->destination));
        when.push_back(time.now());
        telegrams->finish(SendOutcome::kSent, {});
      }
    });
  }
  void push(std::uint16_t group, wire::Priority priority = wire::Priority::kLow,
            wire::Service service = wire::Service::kWrite, Duration lives = 1h) {
    wire::Telegram telegram;
    telegram.destination = wire::GroupAddress{group};
    telegram.priority = priority;
    telegram.service = service;
    if (service != wire::Service::kRead) telegram.payload = {{1}, true};
    telegrams->push(telegram, time.now() + lives,
                    [this, group](SendOutcome sent, std::string_view) { outcomes.emplace_back(group, sent); });
  }

  VirtualScheduler time;
  std::unique_ptr<TelegramQueue> telegrams;
  bool auto_send = true;
  std::vector<std::uint16_t> taken;
  std::vector<SteadyTime> when;
  std::vector<std::pair<std::uint16_t, SendOutcome>> outcomes;
};

TEST_F(OutboxTest, SystemGoesBeforeUrgentNormalAndLowAndInOrderWithin) {
  make({.rate = 0});
  push(1, wire::Priority::kLow);
  push(2, wire::Priority::kNormal);
  push(3, wire::Priority::kUrgent);
  push(4, wire::Priority::kSystem);
  push(5, wire::Priority::kUrgent);
  push(6, wire::Priority::kLow);
  EXPECT_TRUE(taken.empty()) << "not inside push()";
  time.run_ready();
  EXPECT_EQ(taken, (std::vector<std::uint16_t>{4, 3, 5, 2, 1, 6}));
}

TEST_F(OutboxTest, KeepsToTheRateAfterABurst) {
  make({.rate = 20, .burst = 5});
  for (std::uint16_t i = 1; i <= 105; ++i) push(i);
  time.run_ready();
  EXPECT_EQ(taken.size(), 5U);
  time.run_for(1s);
  EXPECT_NEAR(static_cast<double>(taken.size()), 25, 1);
  time.run_for(4s);
  EXPECT_GE(taken.size(), 104U);
  time.run_for(10s);
  EXPECT_EQ(taken.size(), 105U);
  for (std::uint16_t i = 200; i < 210; ++i) push(i);
  time.run_ready();
  EXPECT_EQ(taken.size(), 110U) << "no more than the burst after a long pause";
}

TEST_F(OutboxTest, WithoutARateAllGoesAtOnce) {
  make({.rate = 0});
  for (std::uint16_t i = 1; i <= 1000; ++i) push(i);
  time.run_ready();
  EXPECT_EQ(taken.size(), 1000U);
}

TEST_F(OutboxTest, ReadsUseTheRateThatOthersLeave) {
  make({.rate = 10, .burst = 3});
  for (std::uint16_t i = 1; i <= 10; ++i) push(i, wire::Priority::kSystem, wire::Service::kRead);
  time.run_ready();
  EXPECT_EQ(taken.size(), 2U) << "a token is left";
  push(100);
  time.run_ready();
  EXPECT_EQ(taken.back(), 100);
  for (std::uint16_t i = 101; i <= 110; ++i) push(i);
  time.run_for(900ms);
  EXPECT_EQ(std::count_if(taken.begin(), taken.end(), [](auto group) { return group < 100; }), 2);
  time.run_for(3s);
  EXPECT_EQ(taken.size(), 21U);
}

TEST_F(OutboxTest, RefusesTelegramsBeyondItsBoundInALaterTurn) {
  make({.rate = 20, .burst = 1, .queue = 3});
  auto_send = false;
  for (std::uint16_t i = 1; i <= 4; ++i) push(i);
  EXPECT_TRUE(outcomes.empty());
  time.run_ready();
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_EQ(outcomes[0], (std::pair<std::uint16_t, SendOutcome>{4, SendOutcome::kRefused}));
  EXPECT_EQ(telegrams->waiting(), 3U);
}

TEST_F(OutboxTest, TelegramsThatWaitTooLongExpireInTime) {
  make({.rate = 20});
  auto_send = false;
  push(1, wire::Priority::kLow, wire::Service::kWrite, 2s);
  push(2, wire::Priority::kLow, wire::Service::kRead, 1s);
  push(3, wire::Priority::kLow, wire::Service::kWrite, 10s);
  time.run_for(990ms);
  EXPECT_TRUE(outcomes.empty());
  time.run_for(20ms);
  EXPECT_EQ(outcomes.size(), 1U);
  time.run_for(1s);
  ASSERT_EQ(outcomes.size(), 2U);
  EXPECT_EQ(outcomes[1], (std::pair<std::uint16_t, SendOutcome>{1, SendOutcome::kExpired}));
  EXPECT_EQ(telegrams->waiting(), 1U);
  EXPECT_EQ(telegrams->counters().expired, 2U);
}

TEST_F(OutboxTest, UnconfirmedTelegramsAreSentFirstOnTheNextLineAndOnlyOnceMore) {
  make({.rate = 0});
  auto_send = false;
  push(1);
  push(2, wire::Priority::kSystem);
  EXPECT_EQ(number(telegrams->take()->destination), 2);
  EXPECT_EQ(telegrams->take(), nullptr) << "one at a time";
  telegrams->line_lost();
  push(3, wire::Priority::kSystem);
  EXPECT_EQ(number(telegrams->take()->destination), 2);
  telegrams->line_lost();
  time.run_ready();
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_EQ(outcomes[0], (std::pair<std::uint16_t, SendOutcome>{2, SendOutcome::kLost}));
  EXPECT_EQ(number(telegrams->take()->destination), 3);
}

TEST_F(OutboxTest, UnconfirmedTelegramsWithoutTimeLeftAreReportedLost) {
  make({.rate = 0});
  auto_send = false;
  push(1, wire::Priority::kLow, wire::Service::kWrite, 1s);
  telegrams->take();
  telegrams->line_lost();
  time.run_for(2s);
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_EQ(outcomes[0].second, SendOutcome::kLost);
  EXPECT_EQ(telegrams->take(), nullptr);
}

TEST_F(OutboxTest, TelegramsThatAreSentOnceMoreHaveTimeLeft) {
  make({.rate = 0});
  auto_send = false;
  push(1, wire::Priority::kLow, wire::Service::kWrite, 1s);
  telegrams->take();
  telegrams->line_lost();
  time.run_for(990ms);
  // At that very instant the line comes up, before anybody looked for what is over.
  const auto taken_then = time.after(10ms, [this] { EXPECT_EQ(telegrams->take(), nullptr); });
  push(2, wire::Priority::kLow, wire::Service::kWrite, 5ms);  // the look at it puts the next one off by a step
  time.run_for(1s);
  ASSERT_EQ(outcomes.size(), 2U);
  EXPECT_EQ(outcomes[1], (std::pair<std::uint16_t, SendOutcome>{1, SendOutcome::kLost}));
}

TEST_F(OutboxTest, DestructionCallsNothing) {
  make({.rate = 0, .queue = 0});
  push(1);
  telegrams.reset();
  time.run_for(1s);
  EXPECT_TRUE(outcomes.empty());
}

}  // namespace
}  // namespace rubicon::networks::knx::line
