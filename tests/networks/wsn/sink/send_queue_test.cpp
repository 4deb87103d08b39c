#include "networks/wsn/sink/send_queue.h"

#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"

namespace rubicon::networks::wsn::sink {
namespace {

using namespace std::chrono_literals;

class WsnSendQueue : public testing::Test {
 protected:
  Result<void> push(Lane lane, std::uint8_t number, SteadyTime expires = SteadyTime::max()) {
    Outgoing packet;
    packet.packet = {0, number};
    packet.lane = lane;
    packet.expires = expires;
    packet.done = [this, number](SendResult what) { results.emplace_back(number, what); };
    return queue->push(std::move(packet));
  }
  int take() {
    const auto packet = queue->take();
    return packet ? packet->packet.at(1) : -1;
  }
  std::uint64_t expired() const {
    std::map<std::string, std::uint64_t> counters;
    queue->count(counters);
    return counters.at("expired");
  }

  VirtualScheduler time;
  int ready = 0;
  std::vector<Lane> rooms;
  std::vector<std::pair<int, SendResult>> results;
  std::unique_ptr<SendQueue> queue = std::make_unique<SendQueue>(
      time, 4, SendQueue::Callbacks{[this] { ++ready; }, [this](Lane lane) { rooms.push_back(lane); }});
};

TEST_F(WsnSendQueue, GivesCommandsBeforeClientsBeforeSamplingBeforeProbes) {
  ASSERT_TRUE(push(Lane::kProbe, 4));
  ASSERT_TRUE(push(Lane::kSampling, 3));
  ASSERT_TRUE(push(Lane::kClient, 2));
  ASSERT_TRUE(push(Lane::kCommand, 1));
  ASSERT_TRUE(push(Lane::kCommand, 11));
  for (const int wanted : {1, 11, 2, 3, 4, -1}) EXPECT_EQ(take(), wanted);
}

TEST_F(WsnSendQueue, GivesALaneItsTurnAfterEightPacketsPassedItBy) {
  ASSERT_TRUE(push(Lane::kProbe, 100));
  ASSERT_TRUE(push(Lane::kSampling, 200));
  std::vector<int> order;
  for (std::uint8_t i = 0; i < 12; ++i) {
    ASSERT_TRUE(push(Lane::kCommand, i));
    order.push_back(take());
  }
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 200, 100, 8, 9}));
}

TEST_F(WsnSendQueue, LetsALaneWaitForItsNextTurnAsLong) {
  ASSERT_TRUE(push(Lane::kSampling, 100));
  ASSERT_TRUE(push(Lane::kSampling, 101));
  std::vector<int> turns;
  for (int i = 0; i < 20; ++i) {
    if (queue->waiting(Lane::kCommand) == 0) {
      ASSERT_TRUE(push(Lane::kCommand, 1)) << i;
    }
    if (take() >= 100) turns.push_back(i);
  }
  EXPECT_EQ(turns, (std::vector<int>{8, 17}));
}

TEST_F(WsnSendQueue, CountsThePassedOnlyWhileSomethingWaits) {
  for (std::uint8_t i = 0; i < 20; ++i) {
    ASSERT_TRUE(push(Lane::kCommand, i));
    EXPECT_EQ(take(), i);
  }
  ASSERT_TRUE(push(Lane::kProbe, 100));
  ASSERT_TRUE(push(Lane::kCommand, 21));
  EXPECT_EQ(take(), 21);
}

TEST_F(WsnSendQueue, RefusesWhatAFullLaneCannotHoldAndTellsWhenItCan) {
  for (std::uint8_t i = 0; i < 4; ++i) ASSERT_TRUE(push(Lane::kClient, i));
  EXPECT_EQ(push(Lane::kClient, 9).error().code, ErrorCode::kBusy);
  EXPECT_TRUE(push(Lane::kCommand, 10)) << "each lane is bounded by itself";
  EXPECT_EQ(take(), 10);
  time.run_ready();
  EXPECT_TRUE(rooms.empty());
  EXPECT_EQ(take(), 0);
  EXPECT_TRUE(rooms.empty()) << "in a later turn";
  time.run_ready();
  EXPECT_EQ(rooms, std::vector{Lane::kClient});
  EXPECT_EQ(take(), 1);
  time.run_ready();
  EXPECT_EQ(rooms.size(), 1U) << "once for what was refused";
}

TEST_F(WsnSendQueue, TellsOfRoomThatExpiryMade) {
  for (std::uint8_t i = 0; i < 4; ++i) ASSERT_TRUE(push(Lane::kClient, i, time.now() + 1s));
  EXPECT_FALSE(push(Lane::kClient, 9));
  time.run_for(1s);
  EXPECT_EQ(rooms, std::vector{Lane::kClient});
  EXPECT_EQ(results.size(), 4U);
}

TEST_F(WsnSendQueue, ReportsEachExpiredPacketOnceAtItsTime) {
  ASSERT_TRUE(push(Lane::kCommand, 1, time.now() + 2s));
  ASSERT_TRUE(push(Lane::kSampling, 2, time.now() + 1s));
  ASSERT_TRUE(push(Lane::kSampling, 3));
  time.run_for(999ms);
  EXPECT_TRUE(results.empty());
  time.run_for(1ms);
  EXPECT_EQ(results, (std::vector<std::pair<int, SendResult>>{{2, SendResult::kExpired}}));
  time.run_for(1h);
  EXPECT_EQ(results.size(), 2U);
  EXPECT_EQ(expired(), 2U);
  EXPECT_EQ(take(), 3);
}

TEST_F(WsnSendQueue, NeverGivesWhatHasExpired) {
  // The second one expires between two sweeps.
  ASSERT_TRUE(push(Lane::kCommand, 1, time.now() + 10ms));
  ASSERT_TRUE(push(Lane::kCommand, 2, time.now() + 11ms));
  time.run_for(12ms);
  EXPECT_EQ(take(), -1);
  time.run_ready();
  EXPECT_EQ(results.size(), 2U);
}

TEST_F(WsnSendQueue, AsksForATakerOnceATurn) {
  ASSERT_TRUE(push(Lane::kCommand, 1));
  ASSERT_TRUE(push(Lane::kProbe, 2));
  EXPECT_EQ(ready, 0) << "never from inside";
  time.run_ready();
  EXPECT_EQ(ready, 1);
}

TEST_F(WsnSendQueue, PutsBackInFrontWhatCouldNotLeave) {
  ASSERT_TRUE(push(Lane::kCommand, 1));
  ASSERT_TRUE(push(Lane::kCommand, 2));
  auto packet = queue->take();
  queue->put_back(std::move(*packet));
  EXPECT_EQ(queue->waiting(Lane::kCommand), 2U);
  EXPECT_EQ(take(), 1);
}

TEST_F(WsnSendQueue, TellsNothingOnceItIsGone) {
  for (std::uint8_t i = 0; i < 4; ++i) ASSERT_TRUE(push(Lane::kClient, i, time.now() + 1s));
  EXPECT_FALSE(push(Lane::kClient, 9));
  EXPECT_EQ(take(), 0);
  queue->report([this](SendResult what) { results.emplace_back(0, what); }, SendResult::kAcknowledged);
  queue.reset();
  time.run_for(1h);
  EXPECT_EQ(ready, 0);
  EXPECT_TRUE(rooms.empty());
  EXPECT_TRUE(results.empty());
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
