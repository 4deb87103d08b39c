#include "tuples/peis/deliveries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr OwnerId kHost{101}, kOther{102};

class PeisDeliveries : public ::testing::Test {
 protected:
  struct Out {
    OwnerId to{};
    PackageHeader header;
    std::string body;
    bool urgent = false;
  };
  PeisDeliveries() { deliveries.open(kHost, false); }
  Emitted emit(OwnerId to, std::span<std::uint8_t> package, bool urgent) {
    if (answer != Emitted::kSent) return answer;
    const auto bytes = ByteView(package.data(), package.size());
    out.push_back({to, *read_package_header(bytes), std::string(base::as_text(bytes.subspan(kHeaderSize))), urgent});
    return Emitted::kSent;
  }
  Result<void> send(const std::string& text, OwnerId to = kHost) {
    return deliveries.send(to, Port::kPush, base::as_bytes(text),
                           [this](Outcome outcome) { outcomes.push_back(outcome); });
  }
  void acknowledge(std::size_t index) { deliveries.acknowledged(kHost, Acks{{out.at(index).header.ack_id}}); }
  std::vector<std::string> bodies() const {
    std::vector<std::string> bodies;
    for (const auto& package : out) bodies.push_back(package.body);
    return bodies;
  }

  VirtualScheduler time;
  NodeCounters counters;
  Emitted answer = Emitted::kSent;
  std::vector<Out> out;
  std::vector<Outcome> outcomes;
  std::vector<OwnerId> ready;
  Deliveries deliveries{
      time,
      OwnerId{200},
      0x7ffffffe,
      counters,
      {[this](OwnerId to, std::span<std::uint8_t> package, bool urgent) { return emit(to, package, urgent); },
       [this](OwnerId to) { ready.push_back(to); }}};
};

TEST_F(PeisDeliveries, AResendHasANewPackageIdAndTheSameAckId) {
  ASSERT_TRUE(send("one"));
  time.run_for(500ms);
  ASSERT_THAT(out, SizeIs(2));
  EXPECT_EQ(out[0].header.ack_id, out[1].header.ack_id);
  EXPECT_NE(out[0].header.id, out[1].header.id);
  EXPECT_EQ(out[0].header.flags, kFlagWantsAck);
  acknowledge(0);
  time.run_for(60s);
  EXPECT_THAT(out, SizeIs(2));
  EXPECT_THAT(outcomes, ElementsAre(Outcome::kDelivered));
}

TEST_F(PeisDeliveries, AHelloThatComesAgainForgetsNoMessageThatCame) {
  EXPECT_TRUE(deliveries.is_new(kHost, 5));
  deliveries.widen(kHost);
  EXPECT_FALSE(deliveries.is_new(kHost, 5));
  EXPECT_TRUE(deliveries.is_new(kHost, 6));
  deliveries.widen(kHost);
  EXPECT_FALSE(deliveries.is_new(kHost, 5));
  EXPECT_FALSE(deliveries.is_new(kHost, 6));
}

TEST_F(PeisDeliveries, IdsStayInRangeAndAreNeverZero) {
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(send("x"));
  for (const auto& package : out) {
    EXPECT_GT(package.header.id, 0u);
    EXPECT_LE(package.header.id, kMaxId);
    EXPECT_GT(package.header.ack_id, 0u);
    EXPECT_LE(package.header.ack_id, kMaxId);
  }
}

TEST_F(PeisDeliveries, AcknowledgementsCountInAnyOrderAndOnce) {
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(send("x"));  // the ids begin again among these
  for (const std::size_t index : {7u, 2u, 3u, 2u, 0u, 6u, 1u, 5u}) acknowledge(index);
  deliveries.acknowledged(kHost, Acks{{0, 0xffffffff, kMaxId, 4711}});
  EXPECT_EQ(deliveries.unacknowledged(kHost), 1u);
  acknowledge(4);
  acknowledge(4);
  EXPECT_EQ(deliveries.unacknowledged(kHost), 0u);
  EXPECT_THAT(outcomes, SizeIs(8));
  time.run_for(60s);
  EXPECT_THAT(out, SizeIs(8)) << "nothing is sent again";
}

TEST_F(PeisDeliveries, AFullLinkIsNotAskedForMoreAndGetsTheRestInOrder) {
  ASSERT_TRUE(send("a"));
  answer = Emitted::kFull;
  for (const auto* text : {"b", "c", "d"}) ASSERT_TRUE(send(text));
  time.run_for(300ms);
  answer = Emitted::kSent;
  deliveries.pump();
  EXPECT_THAT(bodies(), ElementsAre("a", "b", "c", "d"));
  for (std::size_t i = 0; i < 4; ++i) acknowledge(i);
  EXPECT_THAT(outcomes, SizeIs(4));
  time.run_for(60s);
  EXPECT_THAT(out, SizeIs(4)) << "the time of a resend begins when a link took it";
}

TEST_F(PeisDeliveries, WithoutARouteTheTimeRunsAndANewLinkGetsAllInOrder) {
  answer = Emitted::kNoRoute;
  for (const auto* text : {"a", "b", "c"}) ASSERT_TRUE(send(text));
  time.run_for(5s);
  answer = Emitted::kSent;
  deliveries.send_again(kHost);
  EXPECT_THAT(bodies(), ElementsAre("a", "b", "c"));
  answer = Emitted::kNoRoute;
  time.run_for(20s);
  EXPECT_THAT(outcomes, ElementsAre(Outcome::kGivenUp, Outcome::kGivenUp, Outcome::kGivenUp));
}

TEST_F(PeisDeliveries, AFragmentGivenUpEndsItsMessageAndTheOthersAreNotSent) {
  ASSERT_TRUE(send(std::string(3000, 'x')));
  ASSERT_THAT(out, SizeIs(3));
  EXPECT_EQ(out[2].header.fragments, 3);
  EXPECT_EQ(out[2].header.fragment, 2);
  EXPECT_EQ(out[0].header.message, out[2].header.message);
  EXPECT_EQ(out[0].header.flags, kFlagWantsAck | kFlagBulk);
  acknowledge(0);
  acknowledge(1);
  EXPECT_THAT(outcomes, IsEmpty());
  time.run_for(30s);
  EXPECT_THAT(outcomes, ElementsAre(Outcome::kGivenUp));
  EXPECT_EQ(counters.given_up, 1u);
  ASSERT_TRUE(send("next"));
  EXPECT_EQ(out.back().body, "next");
  EXPECT_EQ(deliveries.unacknowledged(kHost), 1u);
}

TEST_F(PeisDeliveries, AMessageLongerThanTheWindowGoesInTurn) {
  ASSERT_TRUE(send(std::string(1'000'000, 'x')));
  EXPECT_THAT(out, SizeIs(Deliveries::kFirstOfKernel));
  std::size_t next = 0;
  while (next < out.size()) acknowledge(next++);
  EXPECT_EQ(out.size(), 977u);
  EXPECT_THAT(outcomes, ElementsAre(Outcome::kDelivered));
}

TEST_F(PeisDeliveries, AHostThatIsGoneEndsAllAndItsLateAcksDoNothing) {
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(send("x"));
  deliveries.close(kHost);
  EXPECT_THAT(outcomes, ::testing::AllOf(SizeIs(500), Each(Outcome::kHostGone)));
  acknowledge(0);
  EXPECT_EQ(send("y").error().code, ErrorCode::kNotFound);
  time.run_for(60s);
  EXPECT_THAT(out, SizeIs(Deliveries::kFirstOfKernel));
}

TEST_F(PeisDeliveries, TheWindowOfAKernelFollowsTheTimeOfItsAcks) {
  const auto under_way = [&] { return deliveries.unacknowledged(kHost); };
  const auto fill = [&] {
    while (under_way() < 1000) ASSERT_TRUE(send("x"));
  };
  std::size_t next = 0;
  const auto rounds = [&](Duration delay) {
    for (int i = 0; i < 50; ++i) {
      fill();
      const auto end = out.size();
      time.run_for(delay);
      while (next < end) acknowledge(next++);
    }
    fill();
    const auto window = out.size() - next;
    next = out.size() - window;
    return window;
  };
  EXPECT_EQ(rounds(100ms), Deliveries::kOfKernel.packages);
  EXPECT_EQ(rounds(350ms), Deliveries::kMinOfKernel);
  EXPECT_EQ(rounds(100ms), Deliveries::kOfKernel.packages);
  EXPECT_EQ(counters.resends, 0u);
}

TEST_F(PeisDeliveries, AcksOfAnotherHostAndUnknownOnesDoNothing) {
  deliveries.open(kOther, false);
  ASSERT_TRUE(send("x"));
  deliveries.acknowledged(kOther, Acks{{out[0].header.ack_id}});
  deliveries.acknowledged(kHost, Acks{{100, 200, 300}});
  EXPECT_THAT(outcomes, IsEmpty());
  acknowledge(0);
  acknowledge(0);
  EXPECT_THAT(outcomes, ElementsAre(Outcome::kDelivered));
}

TEST_F(PeisDeliveries, AnOutcomeMaySendAgain) {
  int sent = 1;
  std::function<void(Outcome)> again = [&](Outcome) {
    if (sent++ < 5) {
      ASSERT_TRUE(deliveries.send(kHost, Port::kPush, base::as_bytes("x"), again));
    }
  };
  ASSERT_TRUE(deliveries.send(kHost, Port::kPush, base::as_bytes("x"), again));
  for (std::size_t i = 0; i < 5; ++i) acknowledge(i);
  EXPECT_EQ(sent, 6);
  EXPECT_THAT(out, SizeIs(5));
}

TEST_F(PeisDeliveries, AcksGoOutTogetherAfterAFifthOfASecondOrAHundred) {
  for (std::uint32_t id = 1; id <= 250; ++id) deliveries.acknowledge(kHost, id);
  ASSERT_THAT(out, SizeIs(2));
  EXPECT_EQ(out[0].header.port, Port::kAcks);
  EXPECT_TRUE(out[0].urgent);
  EXPECT_EQ(out[0].header.ack_id, out[0].header.id) << "not acknowledged itself";
  time.run_for(199ms);
  EXPECT_THAT(out, SizeIs(2));
  time.run_for(1ms);
  ASSERT_THAT(out, SizeIs(3));
  EXPECT_EQ(read_acks(base::as_bytes(out[2].body))->ids.size(), 50u);
}

TEST_F(PeisDeliveries, DuplicatesAreKnownByTheirAckIdPerSource) {
  deliveries.open(kOther, true);
  EXPECT_TRUE(deliveries.is_new(kHost, 5));
  EXPECT_FALSE(deliveries.is_new(kHost, 5));
  EXPECT_TRUE(deliveries.is_new(kOther, 5));
  for (std::uint32_t id = 1000; id < 1000 + kDuplicateTable; ++id) EXPECT_TRUE(deliveries.is_new(kHost, id));
  EXPECT_TRUE(deliveries.is_new(kHost, 5)) << "bounded";
}

TEST_F(PeisDeliveries, DuplicatesStayKnownWhenHelloComesAgain) {
  deliveries.widen(kHost);
  EXPECT_TRUE(deliveries.is_new(kHost, 5));
  deliveries.widen(kHost);
  EXPECT_FALSE(deliveries.is_new(kHost, 5));
  deliveries.open(kOther, true);
  EXPECT_TRUE(deliveries.is_new(kOther, 5));
  deliveries.widen(kOther);
  EXPECT_FALSE(deliveries.is_new(kOther, 5));
}

}  // namespace
}  // namespace rubicon::tuples::peis
