#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tuples/component.h"
#include "tuples/dds/dds_test_ecology.h"
#include "tuples/dds/reader_stores.h"
#include "tuples/dds/rogue.h"
#include "tuples/distant/frame_codec.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using distant::FrameWriter;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint32_t kRogue = 66666;

/// An island (1) and a robot (70000) that work together, and somebody who means no good.
struct Rogues : testing::Test, TwoComponentsOf<dds::DdsTestEcology> {
  void SetUp() override {
    ASSERT_TRUE(robot->space.set("a", "1"));
    copies = island->space.subscribe(pattern("a.**"), {}, seen.call());
    a = island->space.subscribe(pattern("a"), {}, seen.call());
    policy = island->space.add_policy(pattern("cmd"), [this](const RemoteSet& set) {
      decided.push_back(set.value);
      return SetDecision::applied();
    });
    until([&] { return island->space.get(kRobot, "a").has_value(); });
    until([&] {
      return !island->space.peers().empty() && island->space.peers().back() == kRobot &&
             island->space.peers().size() == 2;
    });
    seen.take();
  }
  template <class Done>
  bool until(Done done) {
    for (int i = 0; i < 1000 && !done(); ++i) time.run_for(1ms);
    return done();
  }
  void let_pass() {
    for (int i = 0; i < 50; ++i) time.run_for(1ms);
  }
  /// To the island, in its own name.
  void tell(const Bytes& content) { rogue.frame(kRogue, rogue.incarnation(), 1, island_incarnation, content); }
  static Bytes set(std::string_view key, std::string_view value, std::uint64_t sequence) {
    TupleSet change;
    change.tuple.key = key;
    change.tuple.value = value;
    change.tuple.media_type = "text/plain";
    change.tuple.sequence = sequence;
    distant::FrameWriter writer;
    writer.add(change);
    return writer.take();
  }
  static Bytes command(std::uint64_t request, std::string value) {
    RemoteSet set;
    set.request = request;
    set.key = "cmd";
    set.value = std::move(value);
    distant::FrameWriter writer;
    writer.add(set);
    return writer.take();
  }
  /// What the rogue did to it, nobody else noticed.
  void expect_the_others_work() {
    ASSERT_TRUE(robot->space.set("a", "2"));
    EXPECT_TRUE(until([&] { return island->space.get(kRobot, "a")->value == "2"; }));
    Verdict verdict = Verdict::kRefused;
    bool answered = false;
    robot->space.set_remote(kIsland, "cmd", "robot", 60s, [&](const Reply& reply) {
      verdict = reply.verdict;
      answered = true;
    });
    EXPECT_TRUE(until([&] { return answered; }));
    EXPECT_EQ(verdict, Verdict::kApplied);
    EXPECT_THAT(decided, Contains("robot"));
  }

  std::uint64_t island_incarnation =  // it started at the beginning of this time
      static_cast<std::uint64_t>(VirtualScheduler().wall_now().time_since_epoch().count());
  dds::Rogue rogue{kRogue};
  Listener seen;
  std::vector<std::string> decided;
  Handle copies, a, policy;
};

TEST_F(Rogues, SpeakForNobodyElse) {
  rogue.frame(70000, island_incarnation, 1, island_incarnation, set("a", "forged", 99));
  tell(set("a.own", "mine", 1));
  EXPECT_TRUE(until([&] { return !seen.seen.empty(); }));
  EXPECT_THAT(seen.take(), ElementsAre("a.own=mine"));
  EXPECT_EQ(island->space.get(kRobot, "a")->value, "1");
  expect_the_others_work();
}

TEST_F(Rogues, RepeatAndReorderCommandsInVain) {
  for (const std::uint64_t request : {5U, 5U, 4U, 6U, 5U}) tell(command(request, "r" + std::to_string(request)));
  EXPECT_TRUE(until([&] { return decided.size() == 2; }));
  let_pass();
  EXPECT_THAT(decided, ElementsAre("r5", "r6"));
  expect_the_others_work();
}

/// A tool replies to its last message and ends: both may have arrived when the island reads.
TEST_F(Rogues, SendTheirLastFramesBeforeTheyLeave) {
  tell(command(1, "first"));
  ASSERT_TRUE(until([&] { return decided.size() == 1; }));
  tell(command(2, "last"));
  rogue.leave();
  EXPECT_TRUE(until([&] { return island->space.peers() == std::vector{kRobot}; }));
  EXPECT_THAT(decided, ElementsAre("first", "last"));
}

TEST_F(Rogues, OversizedValuesAndUnsoundKeysAreDroppedAndCounted) {
  const auto before = island->space.stats().dropped;
  tell(set("a.huge", std::string(2 << 20, 'x'), 1));
  tell(set("a..b", "x", 1));
  tell(set("a." + std::string(400, 'k'), "x", 1));
  tell(set("a.fine", "x", 1));
  EXPECT_TRUE(until([&] { return !seen.seen.empty(); }));
  EXPECT_THAT(seen.take(), ElementsAre("a.fine=x"));
  EXPECT_GE(island->space.stats().dropped, before + 1);
  expect_the_others_work();
}

/// DDS keeps those for as long as the reader lives.
TEST_F(Rogues, ManyEndsOfWhatNeverWasAreNotKept) {
  rogue.interest(0, {});
  for (std::uint32_t i = 1; i <= dds::EndedInstances::kMaxKept + 100; ++i) {
    rogue.end_interest_of(kRogue, rogue.incarnation(), i);
    if (i % 100 == 0) time.run_for(1ms);
  }
  ASSERT_TRUE(until([&] { return island->space.peers().empty(); })) << "it leaves";
  EXPECT_TRUE(ecology.log().contains("ends more than 4096 keys"));
  time.run_for(4s);
  EXPECT_TRUE(island->space.peers().empty()) << "for a while";
  time.run_for(2s);
  ASSERT_TRUE(until([&] { return island->space.peers() == std::vector{kRobot}; }))
      << "and comes back without the rogue";
  expect_the_others_work();
}

/// As every component does with its subscriptions.
TEST_F(Rogues, ManyEndsThatAreUnregisteredDisturbNobody) {
  rogue.interest(0, {});
  for (std::uint32_t i = 1; i <= dds::EndedInstances::kMaxKept + 100; ++i) {
    rogue.end_interest_of(kRogue, rogue.incarnation(), i, true);
    if (i % 100 == 0) time.run_for(1ms);
  }
  let_pass();
  EXPECT_FALSE(ecology.log().contains("ends more than"));
  expect_the_others_work();
}

TEST_F(Rogues, TenThousandSubscriptionsHarmNobody) {
  for (std::uint32_t i = 0; i < 10'200; ++i) {
    distant::FrameWriter content;
    content.add(SubscriptionSpec{i, pattern("a.k" + std::to_string(i)), {}});
    rogue.interest(i, content.take());
    if (i % 100 == 0) time.run_for(1ms);
  }
  let_pass();
  expect_the_others_work();
  EXPECT_LE(island->space.stats().subscriptions, 10'010U);
}

TEST_F(Rogues, AFloodOfComponentsIsIgnoredAndANewcomerIsSeen) {
  for (std::uint32_t id = 100'000; id < 110'500; ++id) rogue.show(id, rogue.incarnation());
  EXPECT_TRUE(until([&] { return ecology.log().contains("claims more than 16 components: it is ignored"); }));
  let_pass();
  EXPECT_THAT(island->space.peers(), ElementsAre(kRobot)) << "also what it was before";
  const Component newcomer(ecology, time, 70'001);
  EXPECT_TRUE(until([&] { return island->space.peers().size() == 2 && newcomer.space.peers().size() == 2; }));
  EXPECT_THAT(newcomer.space.peers(), ElementsAre(kIsland, kRobot));
  expect_the_others_work();
}

/// More than the island takes at once, and nobody shows anything afterwards.
TEST_F(Rogues, ThatShowAHundredComponentsInABurstAreAllSeen) {
  std::vector<std::unique_ptr<dds::Rogue>> crowd;
  for (std::uint32_t i = 0; i < 7; ++i) {
    auto& one = *crowd.emplace_back(std::make_unique<dds::Rogue>(kRogue + 1 + 100 * i));
    for (std::uint32_t more = 1; more < 15; ++more) one.show(kRogue + 1 + 100 * i + more, one.incarnation());
  }
  for (const auto& one : crowd) one->arrive();
  EXPECT_TRUE(until([&] { return island->space.peers().size() == 2 + 7 * 15; })) << island->space.peers().size();
}

/// A component that this program lost may not have noticed: it sends its tuples to whoever asks for them again.
TEST_F(Rogues, ThatReturnAsTheSameStartAreAskedForTheirTuplesAgain) {
  ASSERT_TRUE(rogue.gets_subscription_of(number(kIsland)));
  rogue.leave();
  ASSERT_TRUE(until([&] { return island->space.peers() == std::vector{kRobot}; }));
  rogue.show(kRogue, rogue.incarnation());
  ASSERT_TRUE(until([&] { return island->space.peers().size() == 2; }));
  time.run_for(2s);
  EXPECT_TRUE(rogue.gets_subscription_of(number(kIsland)));
}

TEST_F(Rogues, ThatShowManyStartsOfOneComponentAreThatComponentOnceAtMost) {
  for (std::uint64_t i = 1; i <= 5'000; ++i) rogue.show(kRogue, rogue.incarnation() + i);
  let_pass();
  EXPECT_LE(ecology.component_starts().size(), 150U);
  EXPECT_THAT(island->space.peers(), ElementsAre(OwnerId(kRogue), kRobot));
  expect_the_others_work();
}

TEST_F(Rogues, ThatShowStartsOfOneComponentAndGoTakeItFromNobody) {
  std::vector<std::unique_ptr<dds::Rogue>> more;
  for (int i = 0; i < 5; ++i) more.push_back(std::make_unique<dds::Rogue>(number(kRobot)));
  more.back()->show(number(kRobot), island_incarnation - 1'000'000);
  const auto starts = [&] {
    const auto all = ecology.component_starts();
    return std::count_if(all.begin(), all.end(), [](const auto& one) { return one.present && one.id == kRobot; });
  };
  EXPECT_TRUE(until([&] { return starts() == 7; }));
  more.push_back(std::make_unique<dds::Rogue>(number(kRobot)));
  EXPECT_TRUE(until([&] { return starts() == 8; }));
  let_pass();
  more.clear();
  EXPECT_TRUE(until([&] { return starts() == 1; }));
  let_pass();
  ASSERT_THAT(island->space.peers(), Contains(kRobot));
  ASSERT_TRUE(until([&] { return island->space.get(kRobot, "a").has_value(); }));
  expect_the_others_work();
}

TEST_F(Rogues, SubscribeForNobodyElse) {
  const auto robots = rogue.incarnation_of(number(kRobot));
  ASSERT_NE(robots, 0U);
  ASSERT_TRUE(island->space.set("mine", "1"));
  std::vector<std::string> wanted;
  const auto watch =
      island->space.watch_demand(pattern("mine"), [&](const Demand& demand) { wanted.emplace_back(demand.key); });
  distant::FrameWriter content;
  content.add(SubscriptionSpec{77, pattern("mine"), {}});
  rogue.interest_of(number(kRobot), robots, 77, content.take());
  let_pass();
  EXPECT_THAT(wanted, IsEmpty());
  distant::FrameWriter own;
  own.add(SubscriptionSpec{77, pattern("mine"), {}});
  rogue.interest(77, own.take());
  EXPECT_TRUE(until([&] { return !wanted.empty(); })) << "in its own name it may";
}

TEST_F(Rogues, EndNobodyElseAndNoSubscriptionOfAnother) {
  const auto robots = rogue.incarnation_of(number(kRobot));
  std::vector<std::string> wanted;
  ASSERT_TRUE(island->space.set("mine", "1"));
  const auto watch =
      island->space.watch_demand(pattern("mine"), [&](const Demand& demand) { wanted.emplace_back(demand.key); });
  const auto copy = robot->space.subscribe(pattern("1:mine"), {}, [](const Event&) {});
  ASSERT_TRUE(until([&] { return !wanted.empty(); }));
  rogue.interest(99, {});  // so that it has a writer
  for (std::uint32_t slot = 0; slot < 10; ++slot) rogue.end_interest_of(number(kRobot), robots, slot);
  rogue.end(number(kRobot), robots);
  rogue.end(number(kIsland), island_incarnation);
  rogue.arrive();
  let_pass();
  EXPECT_THAT(island->space.peers(), Contains(kRobot));
  EXPECT_EQ(wanted.size(), 1U) << "nothing ended";
  const auto starts = ecology.component_starts();
  EXPECT_TRUE(std::any_of(starts.begin(), starts.end(), [](const auto& one) {
    return one.id == kRobot && one.present;
  })) << "another process does not take the id for free";
  ASSERT_TRUE(island->space.set("mine", "2"));
  EXPECT_TRUE(until([&] { return robot->space.get(kIsland, "mine")->value == "2"; }));
  expect_the_others_work();
}

/// As after an address changed: a component enters with a new participant, and others have not noticed yet that the
/// former one is gone.
TEST_F(Rogues, AStartThatASecondParticipantShowsCountsWhenTheFirstIsGone) {
  auto first = std::make_unique<dds::Rogue>(kRogue + 1);
  const auto is_there = [&] {
    const auto peers = island->space.peers();
    return std::count(peers.begin(), peers.end(), OwnerId(kRogue + 1)) == 1;
  };
  ASSERT_TRUE(until(is_there));
  std::vector<PeerEvent> events;
  const auto watch = island->space.watch_peers([&](OwnerId peer, PeerEvent event) {
    if (peer == OwnerId(kRogue + 1)) events.push_back(event);
  });
  const auto start = first->incarnation();
  auto second = std::make_unique<dds::Rogue>(kRogue + 2);
  second->show(kRogue + 1, start);
  second->arrive();
  EXPECT_TRUE(until([&] { return ecology.log().contains("the same start: ignored while the first one is there"); }));
  events.clear();
  first.reset();
  EXPECT_TRUE(until([&] { return events.size() == 2; }));
  EXPECT_THAT(events, ElementsAre(PeerEvent::kLost, PeerEvent::kUp));
  second.reset();
  EXPECT_TRUE(until([&] { return !is_there(); }));
}

/// A component ended, the clock of its host was set back, and it began again before others noticed its end.
TEST_F(Rogues, WhatAStartSaysBeforeADeadOneOfALaterTimeIsGoneCounts) {
  constexpr auto kId = kRogue + 1;
  auto dead = std::make_unique<dds::Rogue>(kId);
  ASSERT_TRUE(until([&] { return island->space.peers().size() == 3; }));
  dds::Rogue next(kId, dds::kProtocolVersion, {}, dead->incarnation() - 3'600'000'000);
  next.arrive();
  next.frame(kId, next.incarnation(), 1, island_incarnation, command(1, "early"));
  let_pass();
  EXPECT_THAT(decided, IsEmpty()) << "the dead one counts, as far as the island knows";
  dead.reset();
  EXPECT_TRUE(until([&] { return !decided.empty(); }));
  EXPECT_THAT(decided, ElementsAre("early"));
}

TEST_F(Rogues, RubbishIsDropped) {
  std::mt19937 dice(7);
  for (int i = 0; i < 500; ++i) {
    Bytes rubbish(dice() % 200);
    for (auto& byte : rubbish) byte = static_cast<std::uint8_t>(dice());
    i % 2 == 0 ? tell(rubbish) : rogue.interest(static_cast<std::uint32_t>(dice() % 20), rubbish);
    time.run_for(1ms);
  }
  let_pass();
  expect_the_others_work();
}

}  // namespace
}  // namespace rubicon::tuples
