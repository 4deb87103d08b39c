#include "networks/wsn/mote_requests.h"

#include <gtest/gtest.h>

#include <map>

#include "networks/wsn/mote_probes.h"
#include "wsn/fake_sink.h"

namespace rubicon::networks::wsn {
namespace {

using namespace std::chrono_literals;

class MoteMail : public ::testing::Test {
 protected:
  MoteRequest request(std::uint16_t mote, bool reliable = true) {
    MoteRequest out;
    out.header = {11, mote, 11, motes::kBaseMote, static_cast<std::uint8_t>(reliable ? 1 : 0), 0, 0, 3, 5, {}};
    out.record = {0x02, 0, 1, 0, 0, 0, 1};
    out.done = [this](Delivered how) { ends.push_back(how); };
    return out;
  }

  VirtualScheduler time;
  FakeSink sink{time};
  MoteRequests requests{time, sink.call()};
  std::vector<Delivered> ends;
};

TEST_F(MoteMail, EndsWithTheAcknowledgementOfTheMote) {
  ASSERT_TRUE(requests.send(request(7)));
  time.run_for(50ms);
  EXPECT_TRUE(ends.empty());
  EXPECT_TRUE(requests.heard(sink.ack(0)));
  EXPECT_EQ(ends, std::vector{Delivered::kAcknowledged});
  EXPECT_EQ(requests.pending(), 0u);
  time.run_for(10s);
  EXPECT_EQ(sink.sent.size(), 1u);
}

TEST_F(MoteMail, TheAcknowledgementOfAnotherMoteOrNumberIsNotOurs) {
  ASSERT_TRUE(requests.send(request(7)));
  auto ack = sink.ack(0);
  ++ack.mote;
  EXPECT_FALSE(requests.heard(ack));
  --ack.mote;
  ++ack.ack.sequence;
  EXPECT_FALSE(requests.heard(ack));
  EXPECT_EQ(requests.pending(), 1u);
}

TEST_F(MoteMail, AMoteThatIsFasterThanItsSinkIsBelieved) {
  sink.answers = false;
  ASSERT_TRUE(requests.send(request(7)));
  EXPECT_TRUE(requests.heard(sink.ack(0)));
  sink.sent[0].done(Sent::kNotAcknowledged);
  time.run_for(10s);
  EXPECT_EQ(ends, std::vector{Delivered::kAcknowledged});
}

TEST_F(MoteMail, RepeatsWithTheSameNumberThreeTimesAndThenSaysThatNobodyAnswers) {
  ASSERT_TRUE(requests.send(request(7)));
  time.run_for(10s);
  ASSERT_EQ(sink.sent.size(), 3u);
  EXPECT_EQ(sink.message(1).sequence, sink.message(0).sequence);
  EXPECT_EQ(ends, std::vector{Delivered::kNoAnswer});
  EXPECT_EQ(requests.unanswered(), 1u);
}

TEST_F(MoteMail, WhatMayNotBeExecutedTwiceIsSentOnce) {
  auto once = request(7);
  once.attempts = 1;
  ASSERT_TRUE(requests.send(std::move(once)));
  time.run_for(10s);
  EXPECT_EQ(sink.sent.size(), 1u);
  EXPECT_FALSE(sink.sent[0].repeatable);
  EXPECT_EQ(ends, std::vector{Delivered::kNoAnswer});
}

TEST_F(MoteMail, WithoutAWishForAcknowledgementTheSinksCounts) {
  ASSERT_TRUE(requests.send(request(7, false)));
  time.run_ready();
  EXPECT_EQ(ends, std::vector{Delivered::kAcknowledged});
  sink.outcome = Sent::kNotAcknowledged;
  ASSERT_TRUE(requests.send(request(7, false)));
  time.run_for(10s);
  EXPECT_EQ(ends.back(), Delivered::kSinkSilent);
}

TEST_F(MoteMail, ASinkThatIsSilentIsNotCalledASilentMote) {
  sink.outcome = Sent::kNotAcknowledged;
  ASSERT_TRUE(requests.send(request(7)));
  time.run_for(20s);
  EXPECT_EQ(ends, std::vector{Delivered::kSinkSilent});
}

TEST_F(MoteMail, WhatCouldNotLeaveInTimeIsExpired) {
  sink.outcome = Sent::kExpired;
  ASSERT_TRUE(requests.send(request(7)));
  time.run_for(20s);
  EXPECT_EQ(ends, std::vector{Delivered::kExpired});
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

TEST_F(MoteMail, ThereIsABoundOfWhatIsPending) {
  for (std::size_t i = 0; i < MoteRequests::kMostPending; ++i) ASSERT_TRUE(requests.send(request(7)));
  EXPECT_EQ(requests.send(request(8)).error().code, ErrorCode::kBusy);
}

TEST_F(MoteMail, TheNumberOfSomebodyElseIsKeptAndCannotBeUnderWayTwice) {
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
  EXPECT_EQ(ends, std::vector{Delivered::kSuperseded});
  time.run_for(10s);
  EXPECT_EQ(sink.sent.size(), 7u) << "the first is not repeated";
}

TEST_F(MoteMail, AnAcknowledgementWithAnErrorIsNoSuccess) {
  ASSERT_TRUE(requests.send(request(7)));
  auto ack = sink.ack(0);
  ack.ack.status = 1;
  EXPECT_TRUE(requests.heard(ack));
  EXPECT_EQ(ends, std::vector{Delivered::kRejected});
}

TEST_F(MoteMail, ItsEndInTheMiddleIsSafe) {
  {
    MoteRequests brief(time, sink.call());
    ASSERT_TRUE(brief.send(request(7)));
  }
  time.run_for(10s);
  EXPECT_TRUE(ends.empty());
}

TEST_F(MoteMail, ProbesGoEightAtATimeInTheLastLane) {
  MoteProbes probes(11, requests);
  std::vector<Delivered> answers;
  for (std::uint16_t mote = 2; mote < 12; ++mote) {
    EXPECT_TRUE(probes.ask(mote, [&](Delivered how) { answers.push_back(how); }));
  }
  EXPECT_FALSE(probes.ask(2, [](Delivered) {})) << "it is being asked";
  ASSERT_EQ(sink.sent.size(), MoteProbes::kAtATime);
  EXPECT_EQ(sink.sent[0].lane, Lane::kProbe);
  EXPECT_EQ(base::to_hex(sink.message(0).record), "00");
  EXPECT_EQ(sink.message(0).reliable, 1);
  for (std::size_t i = 0; i < sink.sent.size(); ++i) requests.heard(sink.ack(i));
  EXPECT_EQ(answers.size(), 10u);
  EXPECT_TRUE(probes.ask(2, [](Delivered) {}));
}

TEST_F(MoteMail, MotesThatDoNotAnswerAreAskedAgainWhenAllOthersWere) {
  MoteProbes probes(11, requests);
  std::map<std::uint16_t, Delivered> answers;
  const auto ask = [&](std::uint16_t mote) {
    EXPECT_TRUE(probes.ask(mote, [&answers, mote](Delivered how) { answers[mote] = how; }));
  };
  for (std::uint16_t mote = 2; mote < 2 + 2 * MoteProbes::kAtATime; ++mote) ask(mote);
  ask(50);
  time.run_for(2s + 100ms);
  ASSERT_GT(sink.sent.size(), 2 * MoteProbes::kAtATime);
  for (std::size_t i = 0; i < sink.sent.size(); ++i) {
    const bool last = i == 2 * MoteProbes::kAtATime;
    EXPECT_EQ(sink.message(i).destination_mote == 50, last) << "after two seconds, not after six: " << i;
    EXPECT_TRUE(sink.sent[i].repeatable);
  }
  requests.heard(sink.ack(2 * MoteProbes::kAtATime));
  EXPECT_EQ(answers[50], Delivered::kAcknowledged);
  time.run_for(10s);
  EXPECT_EQ(sink.sent.size(), 1 + MoteProbes::kAttempts * 2 * MoteProbes::kAtATime);
  EXPECT_EQ(answers.size(), 1 + 2 * MoteProbes::kAtATime);
  EXPECT_EQ(answers[2], Delivered::kNoAnswer);
  EXPECT_EQ(probes.waiting(), 0u);
}

TEST_F(MoteMail, ASilentMoteThatIsAskedForAnewGoesBeforeTheSilentOnes) {
  MoteProbes probes(11, requests);
  int silent = 0;
  for (std::uint16_t mote = 2; mote < 22; ++mote) probes.ask(mote, [&](Delivered) { ++silent; });
  time.run_for(2s + 100ms);  // 16 were asked, 8 are being asked
  bool anew = false;
  EXPECT_FALSE(probes.ask(21, [](Delivered) {})) << "it is being asked";
  EXPECT_TRUE(probes.ask(9, [&](Delivered) { anew = true; }));
  EXPECT_EQ(silent, 1);
  const auto before = sink.sent.size();
  time.run_for(1s);
  ASSERT_GT(sink.sent.size(), before);
  EXPECT_EQ(sink.message(before).destination_mote, 9);
  requests.heard(sink.ack(before));
  EXPECT_TRUE(anew);
}

TEST_F(MoteMail, AProbeWithoutRoomIsAnsweredAndDoesNotBlockTheOthers) {
  MoteProbes probes(11, requests);
  sink.full = true;
  std::vector<Delivered> answers;
  for (std::uint16_t mote = 2; mote < 12; ++mote) probes.ask(mote, [&](Delivered how) { answers.push_back(how); });
  EXPECT_EQ(answers.size(), 10u);
  EXPECT_EQ(probes.waiting(), 0u);
}

}  // namespace
}  // namespace rubicon::networks::wsn
