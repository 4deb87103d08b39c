#include "networks/knx/line/line_fixture.h"

namespace rubicon::networks::knx::line {
namespace {

/// Datagrams get lost, doubled and reordered, each way: knx.md, section 17.
class LossTest : public LineFixture, public testing::WithParamInterface<unsigned> {
 protected:
  static constexpr std::uint16_t kWrites = 200;

  LossTest() { reopen_pause = 200ms; }

  void run_writes(support::KnxServer::Weather weather) {
    connect();
    weather.seed = GetParam();
    server->set_weather(weather);
    const auto begin = time.now();
    for (std::uint16_t i = 0; i < kWrites; ++i) send(i, 120s);
    while (outcomes.size() < kWrites && time.now() - begin < 60s) time.run_for(10ms);
    took = time.now() - begin;
  }

  /// A telegram that arrived is not reported as failed; send() checks that each is reported once.
  void expect_all_delivered() {
    ASSERT_EQ(outcomes.size(), kWrites);
    const auto times = arrivals();
    int more = 0;
    for (std::uint16_t i = 0; i < kWrites; ++i) {
      ASSERT_TRUE(times.contains(i)) << i;
      more += times.at(i) - 1;
      EXPECT_TRUE(sent(i) == SendOutcome::kSent || sent(i) == SendOutcome::kUnconfirmed)
          << i << ": " << outcomes[i].why;
    }
    // Only what was under way when a line was lost goes out once more.
    EXPECT_LE(more, static_cast<int>(count("reconnects")));
  }

  Duration took{};
};

TEST_P(LossTest, ThreePercentEachWayLoseNothing) {
  run_writes({.loss = 0.03});
  expect_all_delivered();
  EXPECT_LT(took, 30s);
  EXPECT_GT(count("repeats") + count("missing-acks"), 0U);
  RecordProperty("seconds", static_cast<int>(took / 1s));
}

TEST_P(LossTest, AtTheRateOfABusItTakesLittleLonger) {
  options.limits = TelegramQueue::Limits{};
  run_writes({.loss = 0.03});
  expect_all_delivered();
  EXPECT_LT(took, 40s);
}

TEST_P(LossTest, DuplicatesAndReorderingChangeNothing) {
  run_writes({.loss = 0.03, .duplicate = 0.05, .reorder = 0.1});
  expect_all_delivered();
  EXPECT_LT(took, 40s);
}

TEST_P(LossTest, TelegramsOfTheBusAreHeardOnceAndInOrderWithoutLoss) {
  connect();
  server->set_weather({.duplicate = 0.2, .reorder = 0.2, .late = 50ms, .seed = GetParam()});
  for (std::uint8_t i = 0; i < 200; ++i) server->inject(0x1101, 0x0a08, 0x80, {1, i});
  time.run_for(60s);
  ASSERT_EQ(received.size(), 200U);
  for (std::uint8_t i = 0; i < 200; ++i) EXPECT_EQ(received[i].payload.bytes[1], i);
}

INSTANTIATE_TEST_SUITE_P(Seeds, LossTest, testing::Values(1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U));

}  // namespace
}  // namespace rubicon::networks::knx::line
