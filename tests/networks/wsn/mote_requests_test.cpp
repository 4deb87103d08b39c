#include "networks/wsn/outgoing.h"

#include <gtest/gtest.h>

#include <map>

#include "networks/wsn/fake_sink.h"
#include "networks/wsn/upkeep.h"

namespace rubicon::networks::wsn {
namespace {

using namespace std::chrono_literals;

class MoteMail : public ::testing::Test {
 protected:
  MoteRequest request(std::uint16_t mote, bool reliable = true) {
    MoteRequest out;
    out.header = {11, mote, 11, motes::kBaseMote, static_cast<std::uint8_t>(reliable ? 1 : 0), 0, 0, 3, 5, {}};
    out.record = {0x02, 0, 1, 0, 0, 0, 1};
    out.done = [this](DeliveryResult how) { ends.push_back(how); };
    return out;
  }

  VirtualScheduler time;
  FakeSink sink{time};
  MoteRequests requests{time, sink.call()};
  std::vector<DeliveryResult> ends;
};

TEST_F(MoteMail, EndsWithTheAcknowledgementOfTheMote) {
  ASSERT_TRUE(requests.send(request(7)));
  time.run_for(50ms);
  EXPECT_TRUE(ends.empty());
  EXPECT_TRUE(requests.acknowledged(sink.ack(0)));
  EXPECT_EQ(ends, std::vector{DeliveryResult::kAcknowledged});
  EXPECT_EQ(requests.pending(), 0u);
  time.run_for(10s);
  EXPECT_EQ(sink.sent.size(), 1u);
}

TEST_F(MoteMail, AnAcknowledgementOfAnotherMoteOrNumberIsIgnored) {
  ASSERT_TRUE(requests.send(request(7)));
  auto ack = sink.ack(0);
  ++ack.mote;
  EXPECT_FALSE(requests.acknowledged(ack));
  --ack.mote;
  ++ack.ack.sequence;
  EXPECT_FALSE(requests.acknowledged(ack));
  EXPECT_EQ(requests.pending(), 1u);
}

TEST_F(MoteMail, AnAcknowledgementBeforeTheSinksIsAccepted) {
  sink.answers = false;
  ASSERT_TRUE(requests.send(request(7)));
  EXPECT_TRUE(requests.acknowledged(sink.ack(0)));
  sink.sent[0].done(sink::SendResult::kNotAcknowledged);
  time.run_for(10s);
  EXPECT_EQ(ends, std::vector{DeliveryResult::kAcknowledged});
}

TEST_F(MoteMail, RepeatsThreeTimesWithTheSameNumberAndThenReportsNoAnswer) {
  ASSERT_TRUE(requests.send(request(7)));
  time.run_for(10s);
  ASSERT_EQ(sink.sent.size(), 3u);
  EXPECT_EQ(sink.message(1).sequence, sink.message(0).sequence);
  EXPECT_EQ(ends, std::vector{DeliveryResult::kNoAnswer});
  EXPECT_EQ(requests.unanswered(), 1u);
}

TEST_F(MoteMail, WhatMayNotBeExecutedTwiceIsSentOnce) {
  auto once = request(7);
  once.attempts = 1;
  ASSERT_TRUE(requests.send(std::move(once)));
  time.run_for(10s);
  EXPECT_EQ(sink.sent.size(), 1u);
  EXPECT_FALSE(sink.sent[0].repeatable);
  EXPECT_EQ(ends, std::vector{DeliveryResult::kNoAnswer});
}

TEST_F(MoteMail, WithoutARequestForAcknowledgementTheSinksCounts) {
  ASSERT_TRUE(requests.send(request(7, false)));
  time.run_ready();
  EXPECT_EQ(ends, std::vector{DeliveryResult::kAcknowledged});
  sink.outcome = sink::SendResult::kNotAcknowledged;
  ASSERT_TRUE(requests.send(request(7, false)));
  time.run_for(10s);
  EXPECT_EQ(ends.back(), DeliveryResult::kSinkSilent);
}

TEST_F(MoteMail, ASinkThatIsSilentIsNotCalledASilentMote) {
  sink.outcome = sink::SendResult::kNotAcknowledged;
  ASSERT_TRUE(requests.send(request(7)));
  time.run_for(20s);
  EXPECT_EQ(ends, std::vector{DeliveryResult::kSinkSilent});
}

TEST_F(MoteMail, AMessageThatReachedTheSinkOnceMayHaveBeenExecuted) {
  ASSERT_TRUE(requests.send(request(7)));
  time.run_ready();
  sink.outcome = sink::SendResult::kNotAcknowledged;
  time.run_for(20s);
  EXPECT_EQ(sink.sent.size(), 3u);
  EXPECT_EQ(ends, std::vector{DeliveryResult::kNoAnswer});
}

TEST_F(MoteMail, AMessageThatCouldNotBeSentInTimeIsExpired) {
  sink.outcome = sink::SendResult::kExpired;
  ASSERT_TRUE(requests.send(request(7)));
  time.run_for(20s);
  EXPECT_EQ(ends, std::vector{DeliveryResult::kExpired});
  EXPECT_EQ(sink.sent.size(), 1u);
}

TEST_F(MoteMail, AFullSinkRefusesTheFirstAttemptAndDelaysARepetition) {
  sink.full = true;
  const auto refused = requests.send(request(7));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBusy);
  EXPECT_EQ(requests.pending(), 0u);
  sink.full = false;
  ASSERT_TRUE(requests.send(request(7)));
  sink.full = true;
  time.run_for(2s);
  EXPECT_EQ(sink.sent.size(), 1u);
  sink.full = false;
  time.run_for(300ms);
  EXPECT_EQ(sink.sent.size(), 2u);
}

TEST_F(MoteMail, NumbersOfOneMoteAreUniqueAndNeverTheMotesNoRoom) {
  std::set<std::uint16_t> numbers;
  for (std::size_t i = 0; i < 4000; ++i) {
    ASSERT_TRUE(requests.send(request(7)));
    const auto number = sink.message(i).sequence;
    EXPECT_TRUE(numbers.insert(number).second);
    EXPECT_NE(number, 0xffff);
  }
}

TEST_F(MoteMail, TheNumberOfPendingRequestsIsLimited) {
  for (std::size_t i = 0; i < MoteRequests::kMaxPending; ++i) ASSERT_TRUE(requests.send(request(7)));
  EXPECT_EQ(requests.send(request(8)).error().code, ErrorCode::kBusy);
}

TEST_F(MoteMail, AGivenSequenceNumberIsKeptAndCannotBePendingTwice) {
  auto routed = request(7);
  routed.sequence = 4660;
  ASSERT_TRUE(requests.send(routed));
  EXPECT_EQ(sink.message(0).sequence, 4660);
  EXPECT_EQ(requests.send(routed).error().code, ErrorCode::kDuplicate);
}

TEST_F(MoteMail, ANewerRequestAboutTheSameEndsTheOlderOne) {
  auto on = request(7), off = request(7), other = request(7);
  on.subject = off.subject = 1;
  other.subject = 2;
  ASSERT_TRUE(requests.send(on));
  ASSERT_TRUE(requests.send(other));
  ASSERT_TRUE(requests.send(off));
  time.run_for(500ms);
  EXPECT_EQ(ends, std::vector{DeliveryResult::kSuperseded});
  time.run_for(10s);
  EXPECT_EQ(sink.sent.size(), 7u) << "the first is not repeated";
}

TEST_F(MoteMail, AnAcknowledgementWithAnErrorIsNoSuccess) {
  ASSERT_TRUE(requests.send(request(7)));
  auto ack = sink.ack(0);
  ack.ack.status = 1;
  EXPECT_TRUE(requests.acknowledged(ack));
  EXPECT_EQ(ends, std::vector{DeliveryResult::kRejected});
}

TEST_F(MoteMail, MayBeDestroyedWhileRequestsArePending) {
  {
    MoteRequests brief(time, sink.call());
    ASSERT_TRUE(brief.send(request(7)));
  }
  time.run_for(10s);
  EXPECT_TRUE(ends.empty());
}

// --- Probes.

class Probing : public MoteMail {
 protected:
  static constexpr std::uint16_t kMany = MoteProbes::kMaxConcurrent;
  bool ask(std::uint16_t mote) {
    return probes.probe(mote, [this, mote](DeliveryResult how) { answers[mote] = how; }).has_value();
  }
  void ask_all(std::uint16_t first, std::uint16_t count) {
    for (auto mote = first; mote < first + count; ++mote) EXPECT_TRUE(ask(mote)) << mote;
  }
  std::size_t asked(std::uint16_t mote) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < sink.sent.size(); ++i) count += sink.message(i).destination_mote == mote;
    return count;
  }

  MoteProbes probes{11, time, requests};
  std::map<std::uint16_t, DeliveryResult> answers;
};

TEST_F(Probing, GoesAFewAtATimeInTheLastLane) {
  ask_all(2, kMany + 2);
  EXPECT_EQ(probes.probe(2, [](DeliveryResult) {}).error().code, ErrorCode::kDuplicate) << "it is being asked";
  ASSERT_EQ(sink.sent.size(), kMany);
  EXPECT_EQ(sink.sent[0].lane, sink::Lane::kProbe);
  EXPECT_EQ(base::to_hex(sink.message(0).record), "00");
  EXPECT_EQ(sink.message(0).reliable, 1);
  for (std::size_t i = 0; i < sink.sent.size(); ++i) requests.acknowledged(sink.ack(i));
  EXPECT_EQ(answers.size(), kMany + 2u);
  EXPECT_TRUE(ask(2));
}

TEST_F(Probing, MotesThatDoNotAnswerAreProbedAgainAfterAllOthers) {
  ask_all(102, 2 * kMany);
  ask(50);
  time.run_for(2s + 100ms);
  ASSERT_GT(sink.sent.size(), 2u * kMany);
  for (std::size_t i = 0; i < sink.sent.size(); ++i) {
    const bool last = i == 2 * kMany;
    EXPECT_EQ(sink.message(i).destination_mote == 50, last) << "after two seconds, not after six: " << i;
    EXPECT_TRUE(sink.sent[i].repeatable);
  }
  requests.acknowledged(sink.ack(2 * kMany));
  EXPECT_EQ(answers[50], DeliveryResult::kAcknowledged);
  time.run_for(10s);
  EXPECT_EQ(sink.sent.size(), 1 + MoteProbes::kAttempts * 2 * kMany);
  EXPECT_EQ(answers.size(), 1 + 2 * kMany);
  EXPECT_EQ(answers[102], DeliveryResult::kNoAnswer);
  EXPECT_EQ(probes.waiting(), 0u);
}

TEST_F(Probing, AMoteThatDidNotAnswerWaitsForThoseNotProbedYet) {
  ask_all(2, kMany);
  time.run_for(500ms);
  ask_all(102, kMany);
  time.run_for(600ms);
  EXPECT_EQ(probes.probe(2, [](DeliveryResult) {}).error().code, ErrorCode::kDuplicate) << "it waits to be asked again";
  ASSERT_EQ(sink.sent.size(), 2u * kMany);
  EXPECT_EQ(sink.message(2 * kMany - 1).destination_mote, 101 + kMany);
  time.run_for(1s);
  EXPECT_EQ(sink.message(2 * kMany).destination_mote, 2);
}

TEST_F(Probing, AProbeWithoutRoomIsAnsweredAndDoesNotBlockTheOthers) {
  sink.full = true;
  ask_all(2, 10);
  EXPECT_EQ(answers.size(), 10u);
  EXPECT_EQ(probes.waiting(), 0u);
}

TEST_F(Probing, AMoteWhoseProbeFoundNoRoomMayBeProbedAgain) {
  sink.full = true;
  ASSERT_TRUE(ask(7));
  EXPECT_EQ(answers[7], DeliveryResult::kExpired);
  sink.full = false;
  ASSERT_TRUE(ask(7));
  requests.acknowledged(sink.ack(0));
  EXPECT_EQ(answers[7], DeliveryResult::kAcknowledged);
}

TEST_F(Probing, ALostMoteIsProbedAtGrowingIntervals) {
  ask(7);
  time.run_for(4s);
  EXPECT_EQ(asked(7), MoteProbes::kAttempts);
  EXPECT_EQ(probes.lost(), 1u);
  EXPECT_EQ(probes.probe(7, [](DeliveryResult) {}).error().code, ErrorCode::kDuplicate) << "busy would count as a loss";
  sink.sent.clear();
  for (int i = 0; i < 600; ++i) {  // each second, for ten minutes
    std::ignore = ask(7);
    time.run_for(1s);
  }
  EXPECT_GE(asked(7), 5u) << "for ever";
  EXPECT_LE(asked(7), 9u);
  probes.heard(7);
  EXPECT_TRUE(ask(7)) << "it is alive";
}

TEST_F(Probing, AfterTheSinkWasAwayNoMoteIsLost) {
  ask_all(2, 5);
  time.run_for(10s);
  EXPECT_EQ(probes.lost(), 5u);
  probes.forget_lost();
  ask_all(2, 5);
}

/// As the proxy asks with `silence: 20s`: after ten seconds of silence, then often. All were heard within two seconds.
TEST_F(Probing, TwoHundredLostMotesDoNotDelayTheOthers) {
  std::map<std::uint16_t, SteadyTime> due, answered;
  for (std::uint16_t mote = 2; mote < 202; ++mote) {
    due[mote] = time.now() + 10s + 10ms * mote;
    answered[mote] = time.now() + 10ms * mote;
  }
  const auto lives = [](std::uint16_t mote) { return mote % 22 == 3; };
  Duration longest{};
  std::size_t heard = 0;
  for (const auto end = time.now() + 10min; time.now() < end; time.run_for(50ms)) {
    for (; heard < sink.sent.size(); ++heard) {
      const auto mote = sink.message(heard).destination_mote;
      if (!lives(mote)) continue;
      requests.acknowledged(sink.ack(heard));
      probes.heard(mote);
      longest = std::max(longest, time.now() - answered[mote]);
      answered[mote] = time.now();
      due[mote] = time.now() + 10s;
    }
    for (auto& [mote, when] : due) {
      if (when > time.now()) continue;
      std::ignore = ask(mote);
      when = time.now() + (lives(mote) ? 1s : 5s);
    }
  }
  EXPECT_LT(longest, 20s) << "then it would be unreachable";
  EXPECT_EQ(probes.lost(), 190u);
  EXPECT_LE(probes.waiting(), 200u);
}

}  // namespace
}  // namespace rubicon::networks::wsn
