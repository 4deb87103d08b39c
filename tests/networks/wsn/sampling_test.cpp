#include "networks/wsn/sampling.h"

#include <gtest/gtest.h>

#include "networks/wsn/fake_sink.h"

namespace rubicon::networks::wsn {
namespace {

using namespace std::chrono_literals;
using motes::PeriodicCommand;

class MoteSampling : public ::testing::Test {
 protected:
  PeriodicCommand command(std::size_t n) { return std::get<PeriodicCommand>(sink.record(n)); }
  void acknowledge(std::size_t n) {
    time.run_ready();
    EXPECT_TRUE(requests.acknowledged(sink.ack(n)));
  }

  /// A report after a period of the mote.
  void report() {
    time.run_for(1s);
    sampling.heard(7, true);
  }

  VirtualScheduler time;
  FakeSink sink{time};
  MoteRequests requests{time, sink.call()};
  std::vector<std::pair<std::uint16_t, std::uint16_t>> acknowledged;
  std::optional<std::uint16_t> measured;
  Sampling sampling{time,
                    requests,
                    {11, false},
                    {[this](std::uint16_t, std::optional<std::uint16_t> mask) { measured = mask; },
                     [this](std::uint16_t mote, std::uint16_t mask) { acknowledged.emplace_back(mote, mask); }}};
};

TEST(MoteTicks, AreMillisecondsOfOneThousandTwentyFourthSeconds) {
  EXPECT_EQ(ticks_of(1000ms), 1024);
  EXPECT_EQ(ticks_of(500ms), 512);
  EXPECT_EQ(ticks_of(64s), 65535);
  EXPECT_EQ(ticks_of(24h), 65535);
  EXPECT_EQ(ticks_of(0ms), 51) << "never 0, which was never tried";
  EXPECT_EQ(ticks_of(1ms), 51);
}

TEST_F(MoteSampling, AMoteWithoutAnyDemandIsNeverSentACommand) {
  ASSERT_TRUE(sampling.demand(7, {}));
  sampling.heard(7, false);
  sampling.joined(7);
  time.run_for(10min);
  sampling.heard(7, false);
  EXPECT_TRUE(sink.sent.empty());
}

TEST_F(MoteSampling, SendsExactlyTheDemandReliably) {
  ASSERT_TRUE(sampling.demand(7, {0x0043, 1024}));
  ASSERT_EQ(sink.sent.size(), 1u);
  EXPECT_EQ(command(0).transducers, 0x0043);
  EXPECT_EQ(command(0).period_ms, 1024);
  EXPECT_EQ(sink.message(0).reliable, 1);
  EXPECT_EQ(sink.message(0).application, motes::kApplicationMockup);
  EXPECT_EQ(sink.sent[0].lane, sink::Lane::kSampling);
  EXPECT_TRUE(acknowledged.empty());
  acknowledge(0);
  EXPECT_EQ(acknowledged.back(), std::pair(std::uint16_t{7}, std::uint16_t{0x0043}));
}

TEST_F(MoteSampling, WithTheLastSubscriberItGoesAsSlowAsTheFirmwareCan) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  acknowledge(0);
  ASSERT_TRUE(sampling.demand(7, {}));
  ASSERT_EQ(sink.sent.size(), 2u);
  EXPECT_EQ(command(1).transducers, 0);
  EXPECT_EQ(command(1).period_ms, 65535);
  acknowledge(1);
  sampling.heard(7, true);
  time.run_for(1min);
  EXPECT_EQ(sink.sent.size(), 2u);
}

TEST_F(MoteSampling, AChangeWhileACommandIsUnderWayIsSentAfterIt) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  ASSERT_TRUE(sampling.demand(7, {0x0003, 512}));
  EXPECT_EQ(sink.sent.size(), 1u);
  acknowledge(0);
  ASSERT_EQ(sink.sent.size(), 2u);
  EXPECT_EQ(command(1).transducers, 0x0003);
  EXPECT_EQ(command(1).period_ms, 512);
}

TEST_F(MoteSampling, AMoteThatDidNotAnswerGetsTheCommandAgainWhenItIsHeard) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  time.run_for(7s);
  EXPECT_EQ(sink.sent.size(), 3u);
  EXPECT_TRUE(acknowledged.empty());
  sampling.heard(7, false);
  EXPECT_EQ(sink.sent.size(), 4u);
  acknowledge(3);
  sampling.heard(7, true);
  time.run_for(5min);
  EXPECT_EQ(sink.sent.size(), 4u);
}

TEST_F(MoteSampling, AMoteThatIsNotHeardGetsTheCommandAgainAtGrowingIntervals) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  time.run_for(8500ms);
  EXPECT_EQ(sink.sent.size(), 4u) << "5 s after the third attempt";
  time.run_for(10min);
  const auto before = sink.sent.size();
  EXPECT_GT(before, 20u);
  time.run_for(10min);
  EXPECT_NEAR(static_cast<double>(sink.sent.size() - before), 10 * 3, 4) << "each minute three attempts";
  ASSERT_TRUE(sampling.demand(7, {}));
  time.run_for(2min);
  const auto end = sink.sent.size();
  time.run_for(10min);
  EXPECT_EQ(sink.sent.size(), end) << "there is no demand any longer";
}

TEST_F(MoteSampling, ANewDemandDoesNotWaitForThePausesOfTheFormerOne) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  time.run_for(10min);
  while (requests.pending() > 0) time.run_for(100ms);
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  const auto before = sink.sent.size();
  time.run_for(8500ms);
  ASSERT_EQ(sink.sent.size(), before + 3) << "two more attempts, and one 5 s after the third";
  EXPECT_EQ(command(before).transducers, 0x0003);
}

TEST_F(MoteSampling, AMoteThatWasSwitchedOffAndOnGetsItsCommandAtOnce) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  acknowledge(0);
  sampling.joined(7);
  ASSERT_EQ(sink.sent.size(), 2u);
  EXPECT_EQ(command(1).transducers, 0x0001);
}

TEST_F(MoteSampling, ARepeatedDemandSendsTheCommandAgain) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  acknowledge(0);
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  EXPECT_EQ(sink.sent.size(), 2u);
}

TEST_F(MoteSampling, AMoteThatReportsWithoutDemandIsThrottledButNotOften) {
  sampling.heard(7, true);
  EXPECT_TRUE(sink.sent.empty()) << "its subscribers may be about to find us again";
  time.run_for(10s);
  sampling.heard(7, true);
  ASSERT_EQ(sink.sent.size(), 1u);
  EXPECT_EQ(command(0).transducers, 0);
  time.run_for(4s);  // no answer to three attempts
  sampling.heard(7, true);
  EXPECT_EQ(sink.sent.size(), 3u);
  time.run_for(1s);
  sampling.heard(7, true);
  EXPECT_EQ(sink.sent.size(), 4u);
}

TEST_F(MoteSampling, OfManyThatReportWithoutDemandAFewAtATimeAreThrottled) {
  time.run_for(10s);
  for (std::uint16_t mote = 2; mote < 200; ++mote) sampling.heard(mote, true);
  EXPECT_EQ(sink.sent.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) acknowledge(i);
  for (std::uint16_t mote = 2; mote < 200; ++mote) sampling.heard(mote, true);
  EXPECT_EQ(sink.sent.size(), 16u);
}

TEST_F(MoteSampling, AfterABroadcastOfAnotherProgramNoMoteIsThrottled) {
  sampling.override_begins(motes::kBroadcast, 0x0001);
  time.run_for(10s);
  for (std::uint16_t mote = 2; mote < 5; ++mote) sampling.heard(mote, true);
  EXPECT_TRUE(sink.sent.empty());
  time.run_for(1h);
  sampling.heard(2, true);
  EXPECT_EQ(sink.sent.size(), 1u) << "an hour later the program may no longer want it";
}

TEST_F(MoteSampling, ACommandOverriddenWhileUnderWayDoesNotCount) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  sampling.override_begins(7, 0x0001);
  acknowledge(0);
  EXPECT_EQ(measured, 0) << "not the next report";
  sampling.heard(7, true);
  EXPECT_EQ(measured, std::nullopt);
  time.run_for(6s);
  sampling.heard(7, true);
  EXPECT_EQ(sink.sent.size(), 2u) << "our subscriber takes precedence";
}

TEST_F(MoteSampling, AfterAnAttemptWithoutAnswerOnlyWhatIsCommonToAllAttemptsIsFresh) {
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  acknowledge(0);
  ASSERT_TRUE(sampling.demand(7, {0x0042, 1024}));
  time.run_for(4s);
  ASSERT_TRUE(sampling.demand(7, {0x0041, 1024}));
  EXPECT_EQ(measured, 0);
}

TEST_F(MoteSampling, ReportsForAnotherProgramAreNotThrottled) {
  sampling.override_begins(7, 0x0001);
  time.run_for(10s);
  sampling.heard(7, true);
  EXPECT_TRUE(sink.sent.empty());
}

TEST_F(MoteSampling, AMoteThatWasSwitchedOffAndOnForgotTheOtherProgramsCommand) {
  sampling.override_begins(7, 0x0001);
  time.run_for(10s);
  sampling.heard(7, true);
  ASSERT_TRUE(sink.sent.empty());
  sampling.joined(7);
  sampling.heard(7, true);
  ASSERT_EQ(sink.sent.size(), 1u);
  EXPECT_EQ(command(0).transducers, 0);
}

TEST_F(MoteSampling, OurSubscribersTakePrecedenceOverAnotherProgram) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  acknowledge(0);
  sampling.override_begins(7, 0x0001);
  time.run_for(6s);
  sampling.heard(7, true);
  ASSERT_EQ(sink.sent.size(), 2u);
  EXPECT_EQ(command(1).transducers, 0x0001);
}

TEST_F(MoteSampling, AFullSinkRefusesAndTheCommandIsSentLater) {
  sink.full = true;
  EXPECT_EQ(sampling.demand(7, {0x0001, 1024}).error().code, ErrorCode::kBusy);
  sink.full = false;
  time.run_for(5s);
  EXPECT_EQ(sink.sent.size(), 1u);
}

// --- What of the reports was measured.

TEST_F(MoteSampling, TheFirstReportAfterACommandHoldsNothingThatWasMeasured) {
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  EXPECT_EQ(measured, 0) << "it did not answer yet";
  acknowledge(0);
  EXPECT_EQ(measured, 0);
  report();
  EXPECT_EQ(measured, 0x0003);
  report();
  EXPECT_EQ(measured, 0x0003);
}

TEST_F(MoteSampling, ASensorThatIsAddedMissesOneReportAndTheOthersNone) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  acknowledge(0);
  report();
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  EXPECT_EQ(measured, 0x0001);
  acknowledge(1);
  EXPECT_EQ(measured, 0x0001);
  report();
  EXPECT_EQ(measured, 0x0003);
}

TEST_F(MoteSampling, ASensorThatIsAddedTwiceBeforeAReportMissesThatReport) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  acknowledge(0);
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  acknowledge(1);
  EXPECT_EQ(measured, 0);
  report();
  EXPECT_EQ(measured, 0x0003);
}

TEST_F(MoteSampling, ANewPeriodAloneMissesNoReport) {
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  acknowledge(0);
  report();
  ASSERT_TRUE(sampling.demand(7, {0x0003, 512}));
  acknowledge(1);
  EXPECT_EQ(measured, 0x0003);
}

TEST_F(MoteSampling, AMoteThatWasQuietMayHaveBeenSwitchedOffAndMissesAReport) {
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  acknowledge(0);
  report();
  time.run_for(4s);
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  acknowledge(1);
  EXPECT_EQ(measured, 0);
  report();
  EXPECT_EQ(measured, 0x0003);
}

TEST_F(MoteSampling, AfterASwitchOffAndOnTheFirstReportHoldsNothing) {
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  acknowledge(0);
  report();
  sampling.joined(7);
  EXPECT_EQ(measured, 0);
  acknowledge(1);
  report();
  EXPECT_EQ(measured, 0x0003);
}

TEST_F(MoteSampling, UntilAMoteAnswersOnlyWhatItReadsEitherWayIsFresh) {
  ASSERT_TRUE(sampling.demand(7, {0x0003, 1024}));
  acknowledge(0);
  report();
  ASSERT_TRUE(sampling.demand(7, {0x0042, 1024}));
  EXPECT_EQ(measured, 0x0002);
  acknowledge(1);
  EXPECT_EQ(measured, 0x0002);
  report();
  EXPECT_EQ(measured, 0x0042);
}

TEST_F(MoteSampling, AMoteThatNeverAnsweredReportsForAnotherProgram) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  report();
  EXPECT_EQ(measured, 0);
  time.run_for(3s);
  EXPECT_EQ(measured, std::nullopt);
  time.run_for(5s);
  EXPECT_GT(sink.sent.size(), 3u) << "it gets the command again";
  EXPECT_EQ(measured, std::nullopt);
}

TEST_F(MoteSampling, WhatAnotherProgramAskedForIsMeasuredFromItsSecondReportOn) {
  sampling.heard(7, false);
  sampling.override_begins(7, 0x0003);
  EXPECT_EQ(measured, 0);
  sampling.override_ends(7, 0x0003);
  EXPECT_EQ(measured, 0);
  report();
  EXPECT_EQ(measured, 0x0003);
  sampling.override_begins(7, 0x0001);
  sampling.override_ends(7, std::nullopt);
  EXPECT_EQ(measured, std::nullopt) << "unknown whether it arrived";
}

// --- The end.

/// Motes that we activated, and one that we did not.
class MoteSamplingEnds : public MoteSampling {
 protected:
  using Motes = std::vector<std::uint16_t>;
  void wake(std::uint16_t first, std::uint16_t count) {
    for (auto mote = first; mote < first + count; ++mote) {
      ASSERT_TRUE(sampling.demand(mote, {0x0001, 1024}));
      acknowledge(sink.sent.size() - 1);
    }
    sink.sent.clear();
  }
  bool close() {
    return sampling.close(1800ms, [this](const Motes& motes) { untold = motes; });
  }
  std::optional<Motes> untold;
};

TEST_F(MoteSamplingEnds, OnlyMotesThatWeActivatedAreStopped) {
  wake(7, 2);
  sampling.heard(9, true);
  wake(10, 1);
  sampling.override_begins(10, 0x0001);
  EXPECT_EQ(sampling.active(), (Motes{7, 8}));
  ASSERT_TRUE(close());
  ASSERT_EQ(sink.sent.size(), 2u);
  EXPECT_EQ(command(0).transducers, 0);
  EXPECT_EQ(command(0).period_ms, 65535);
  EXPECT_EQ(untold, std::nullopt);
  acknowledge(0);
  acknowledge(1);
  time.run_for(1ms);
  EXPECT_EQ(untold, Motes{});
  EXPECT_EQ(sampling.demand(7, {0x0001, 1024}).error().code, ErrorCode::kUnreachable);
  time.run_for(10min);
  EXPECT_EQ(sink.sent.size(), 2u);
}

TEST_F(MoteSamplingEnds, MotesThatDoNotAnswerInTimeAreNamed) {
  wake(7, 20);
  ASSERT_TRUE(close());
  EXPECT_EQ(sink.sent.size(), 8u) << "the sink takes a few at a time";
  for (std::size_t i = 0; i < 12; ++i) acknowledge(i);
  time.run_for(1700ms);
  EXPECT_EQ(untold, std::nullopt);
  time.run_for(200ms);
  EXPECT_EQ(untold, (Motes{19, 20, 21, 22, 23, 24, 25, 26}));
}

TEST_F(MoteSamplingEnds, MotesThatAcknowledgeTheStopWithAnErrorAreNamedToo) {
  wake(7, 2);
  ASSERT_TRUE(close());
  acknowledge(0);
  auto error = sink.ack(1);
  error.ack.status = 1;
  EXPECT_TRUE(requests.acknowledged(error));
  time.run_for(1ms);
  EXPECT_EQ(untold, Motes{8});
}

TEST_F(MoteSamplingEnds, ACommandThatIsUnderWayIsFollowedByTheStop) {
  ASSERT_TRUE(sampling.demand(7, {0x0001, 1024}));
  ASSERT_TRUE(close());
  acknowledge(0);
  ASSERT_EQ(sink.sent.size(), 2u);
  EXPECT_EQ(command(1).transducers, 0);
  acknowledge(1);
  time.run_for(1ms);
  EXPECT_EQ(untold, Motes{});
}

TEST_F(MoteSamplingEnds, ThereIsNothingToSendIfNoMoteWasActivated) {
  wake(7, 1);
  ASSERT_TRUE(sampling.demand(7, {}));
  acknowledge(0);
  EXPECT_FALSE(close());
  time.run_for(10s);
  EXPECT_EQ(untold, std::nullopt);
}

TEST_F(MoteSampling, MotesWithTheControlModuleAreAskedForUpdates) {
  sampling.change({11, true});
  ASSERT_TRUE(sampling.demand(7, {0x0043, 512}));
  EXPECT_EQ(sink.message(0).application, motes::kApplicationControl);
  const auto asked = std::get<motes::ReadUpdates>(sink.record(0));
  EXPECT_EQ(asked.transducers, 0x0043);
  EXPECT_EQ(asked.period_ms, 512);
}

}  // namespace
}  // namespace rubicon::networks::wsn
