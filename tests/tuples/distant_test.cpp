#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

struct Distant : testing::Test, TwoComponents {
  Listener listener;
};

TEST_F(Distant, ASubscriberSeesTheLatestOfATurn) {
  const auto handle = robot->space.subscribe(pattern("a"), {}, listener.call());
  time.run_ready();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(island->space.set("a", std::to_string(i)));
  time.run_ready();
  EXPECT_THAT(listener.take(), ElementsAre("a=9"));
  EXPECT_EQ(robot->space.get(kIsland, "a")->sequence, 10u);
  EXPECT_EQ(island->space.stats().merged, 9u);
}

TEST_F(Distant, InitialValuesComeAndCopiesCarryEverything) {
  ASSERT_TRUE(island->space.set("a", "[1]", {"application/json", WallTime{3s}, 60s}));
  const auto handle = robot->space.subscribe(pattern("1:*"), {}, listener.call());
  time.run_ready();
  EXPECT_THAT(listener.take(), ElementsAre("a=[1]"));
  const auto copy = *robot->space.get(kIsland, "a");
  EXPECT_EQ(copy.owner, kIsland);
  EXPECT_EQ(copy.media_type, "application/json");
  EXPECT_EQ(copy.user_time, WallTime{3s});
  EXPECT_EQ(copy.expire_time - copy.write_time, 60s);
}

TEST_F(Distant, DeletedAndExpiredAreToldApart) {
  const auto handle = robot->space.subscribe(pattern("**"), {}, listener.call());
  ASSERT_TRUE(island->space.set("a", "1"));
  ASSERT_TRUE(island->space.set("b", "2", {.lifetime = 1s}));
  time.run_ready();
  listener.take();
  ASSERT_TRUE(island->space.erase("a"));
  time.run_for(1s);
  EXPECT_THAT(listener.take(), ElementsAre("a deleted", "b expired"));
  EXPECT_EQ(robot->space.stats().cached, 0u);
}

TEST_F(Distant, DeletionAndRecreationInOneTurnEndRight) {
  const auto handle = robot->space.subscribe(pattern("a"), {}, listener.call());
  ASSERT_TRUE(island->space.set("a", "1"));
  time.run_ready();
  listener.take();
  ASSERT_TRUE(island->space.set("a", "2"));
  ASSERT_TRUE(island->space.erase("a"));
  ASSERT_TRUE(island->space.set("a", "3"));
  time.run_ready();
  EXPECT_THAT(listener.take(), ElementsAre("a deleted", "a=3"));
  EXPECT_EQ(robot->space.get(kIsland, "a")->value, "3");
}

TEST_F(Distant, ACopyExpiresOnItsOwnClockWhenTheOwnerIsOutOfReach) {
  const auto handle = robot->space.subscribe(pattern("a"), {}, listener.call());
  ASSERT_TRUE(island->space.set("a", "1", {.lifetime = 10s}));
  time.run_for(2s);
  ecology.cut(kIsland, kRobot);
  time.run_for(8s);
  EXPECT_THAT(listener.take(), ElementsAre("a=1", "a expired"));
}

TEST_F(Distant, ACopyStaysWhenItsOwnerEndsTheLifetime) {
  const auto handle = robot->space.subscribe(pattern("a"), {}, listener.call());
  ASSERT_TRUE(island->space.set("a", "1", {.lifetime = 10s}));
  time.run_for(1s);
  ASSERT_TRUE(island->space.set("a", "2"));
  time.run_for(20s);
  EXPECT_THAT(listener.take(), ElementsAre("a=1", "a=2"));
  EXPECT_EQ(robot->space.get(kIsland, "a")->expire_time, WallTime{});
}

TEST_F(Distant, CopiesGoWithTheLastSubscriptionThatCoversThem) {
  auto wide = robot->space.subscribe(pattern("**"), {}, listener.call());
  auto narrow = robot->space.subscribe(pattern("a.b"), {}, listener.call());
  ASSERT_TRUE(island->space.set("a.b", "1"));
  ASSERT_TRUE(island->space.set("a.c", "1"));
  time.run_ready();
  EXPECT_EQ(robot->space.stats().cached, 2u);
  wide.reset();
  time.run_ready();
  EXPECT_EQ(robot->space.stats().cached, 1u);
  narrow.reset();
  time.run_ready();
  EXPECT_EQ(robot->space.stats().cached, 0u);
  EXPECT_FALSE(robot->space.get(kIsland, "a.b"));
  const auto island_tuple = *island->space.find("a.b");
  EXPECT_FALSE(island->space.has_subscriber(island_tuple));
}

TEST_F(Distant, TwoSubscriptionsOfOneComponentCostOneChange) {
  const auto first = robot->space.subscribe(pattern("a.*"), {}, listener.call());
  const auto second = robot->space.subscribe(pattern("*.b"), {}, listener.call());
  time.run_ready();
  ASSERT_TRUE(island->space.set("a.b", "1"));
  time.run_ready();
  EXPECT_THAT(listener.take(), ElementsAre("a.b=1", "a.b=1"));
  EXPECT_EQ(robot->space.get(kIsland, "a.b")->sequence, 1u);
}

TEST_F(Distant, AComponentThatComesLaterGetsTheSubscriptions) {
  const auto handle = robot->space.subscribe(pattern("*:a"), {}, listener.call());
  time.run_ready();
  Component late(ecology, time, 2);
  ASSERT_TRUE(late.space.set("a", "1"));
  time.run_ready();
  EXPECT_THAT(listener.take(), ElementsAre("a=1"));
}

TEST_F(Distant, AfterACutCopiesStayReadableAndThenAgree) {
  const auto handle = robot->space.subscribe(pattern("**"), {}, listener.call());
  for (const auto* key : {"same", "changed", "deleted"}) ASSERT_TRUE(island->space.set(key, "1"));
  time.run_ready();
  listener.take();
  ecology.cut(kIsland, kRobot);
  time.run_ready();
  ASSERT_TRUE(island->space.set("changed", "2"));
  ASSERT_TRUE(island->space.set("new", "3"));
  ASSERT_TRUE(island->space.erase("deleted"));
  time.run_for(10s);
  EXPECT_THAT(listener.take(), IsEmpty());
  EXPECT_EQ(robot->space.get(kIsland, "changed")->value, "1");
  EXPECT_TRUE(robot->space.peers().empty());
  ecology.mend(kIsland, kRobot);
  time.run_ready();
  EXPECT_THAT(listener.take(), testing::UnorderedElementsAre("changed=2", "new=3", "deleted deleted"));
  EXPECT_FALSE(robot->space.get(kIsland, "deleted"));
}

TEST_F(Distant, ANewIncarnationReplacesWhatTheOldOneSaid) {
  const auto handle = robot->space.subscribe(pattern("**"), {}, listener.call());
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(island->space.set("a", "old"));
  ASSERT_TRUE(island->space.set("b", "old"));
  time.run_ready();
  listener.take();
  island.reset();
  time.run_ready();
  EXPECT_EQ(robot->space.get(kIsland, "a")->value, "old");
  island = std::make_unique<Component>(ecology, time, 1);
  ASSERT_TRUE(island->space.set("a", "new"));
  time.run_ready();
  // Where it was seen before it set anything, the old "a" went first.
  EXPECT_THAT(listener.seen, testing::IsSupersetOf({"a=new", "b deleted"}));
  EXPECT_LE(listener.take().size(), kMeetAtOnce ? 2U : 3U);
  EXPECT_EQ(robot->space.get(kIsland, "a")->sequence, 1u);
}

TEST_F(Distant, PeersAreSeenComingAndGoing) {
  std::vector<std::pair<OwnerId, PeerEvent>> seen;
  const auto handle = robot->space.watch_peers([&](OwnerId peer, PeerEvent event) { seen.emplace_back(peer, event); });
  time.run_ready();
  EXPECT_THAT(robot->space.peers(), ElementsAre(kIsland));
  if (kMeetAtOnce) seen.erase(seen.begin());  // over DDS they had met before anybody watched
  ecology.cut(kIsland, kRobot);
  time.run_ready();
  ecology.mend(kIsland, kRobot);
  time.run_ready();
  island.reset();
  time.run_ready();
  EXPECT_THAT(seen, ElementsAre(std::pair(kIsland, PeerEvent::kLost), std::pair(kIsland, PeerEvent::kUp),
                                std::pair(kIsland, PeerEvent::kLeft)));
}

TEST_F(Distant, WhatAComponentSaysOfItselfIsSeenByLatecomersAndWhenItChanges) {
  ASSERT_TRUE(island->space.describe("home"));
  Component late(ecology, time, 70001);
  std::vector<std::pair<OwnerId, std::string>> seen;
  const auto handle =
      late.space.watch_summaries([&](OwnerId peer, std::string_view summary) { seen.emplace_back(peer, summary); });
  std::vector<PeerEvent> peers;
  const auto others = late.space.watch_peers([&](OwnerId, PeerEvent event) { peers.push_back(event); });
  time.run_for(1s);
  EXPECT_EQ(late.space.summary(kIsland), "home");
  EXPECT_EQ(late.space.summary(kRobot), "");
  seen.clear();
  peers.clear();
  ASSERT_TRUE(island->space.describe("home, 3 devices"));
  time.run_for(1s);
  EXPECT_THAT(seen, ElementsAre(std::pair(kIsland, std::string("home, 3 devices"))));
  EXPECT_THAT(peers, IsEmpty()) << "nobody came or went";
  EXPECT_EQ(late.space.summary(kIsland), "home, 3 devices");
  EXPECT_EQ(island->space.describe(std::string(kMaxSummary + 1, 'x')).error().code, ErrorCode::kOutOfRange);
  island.reset();
  time.run_for(1s);
  EXPECT_EQ(late.space.summary(kIsland), "");
}

TEST_F(Distant, ASnapshotIsToldWhenAllOfItIsHere) {
  constexpr int kTuples = 5'000;
  for (int i = 0; i < kTuples; ++i) ASSERT_TRUE(island->space.set("a.t" + std::to_string(i), "x"));
  std::vector<std::size_t> at_end;
  const auto handle = robot->space.subscribe(pattern("a.*"), {}, listener.call(), [&](OwnerId owner) {
    EXPECT_EQ(owner, kIsland);
    at_end.push_back(robot->space.stats().cached);
  });
  time.run_for(1s);
  EXPECT_THAT(at_end, ElementsAre(kTuples));
  std::size_t snapshots = 0;
  const auto nothing = robot->space.subscribe(pattern("b"), {}, listener.call(), [&](OwnerId) { ++snapshots; });
  time.run_for(1s);
  EXPECT_EQ(snapshots, 1U);
}

TEST_F(Distant, TheEndOfOneSnapshotSaysNothingOfTheTuplesOfAnother) {
  const auto first = robot->space.subscribe(pattern("a"), {}, listener.call());
  const auto second = robot->space.subscribe(pattern("b.*"), {}, listener.call());
  ASSERT_TRUE(island->space.set("a", "1"));
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(island->space.set("b.t" + std::to_string(i), "x"));
  time.run_for(1s);
  listener.take();
  ecology.cut(kIsland, kRobot);
  time.run_ready();
  ecology.mend(kIsland, kRobot);
  time.run_for(1s);
  EXPECT_THAT(listener.take(), IsEmpty()) << "nothing changed meanwhile";
}

TEST_F(Distant, CopiesOfALostOwnerAreMarkedAndGoAfterTheGrace) {
  const auto handle = robot->space.subscribe(pattern("**"), {}, listener.call());
  ASSERT_TRUE(island->space.set("a", "1"));
  time.run_ready();
  ecology.cut(kIsland, kRobot);
  time.run_for(kOwnerGrace - 1s);
  EXPECT_FALSE(robot->space.get(kIsland, "a")->owner_present);
  ecology.mend(kIsland, kRobot);
  time.run_for(2s);
  EXPECT_TRUE(robot->space.get(kIsland, "a")->owner_present);
  ecology.cut(kIsland, kRobot);
  listener.take();
  time.run_for(kOwnerGrace + 1s);
  EXPECT_THAT(listener.take(), ElementsAre("a lost"));
  EXPECT_FALSE(robot->space.get(kIsland, "a"));
  ecology.mend(kIsland, kRobot);
  time.run_for(1s);
  EXPECT_THAT(listener.take(), ElementsAre("a=1"));
}

TEST_F(Distant, OfAnOwnerThatIsLostAllIsToldWithinAMinuteOfItsLastSignOfLife) {
  constexpr auto kLease = 15s;
  const auto handle = robot->space.subscribe(pattern("**"), {}, listener.call());
  ASSERT_TRUE(island->space.set("a", "1"));
  time.run_for(1s);
  listener.take();
  const auto last_sign = time.now();
  time.run_for(kLease);  // in silence
  ecology.cut(kIsland, kRobot);
  while (listener.seen.empty() && time.now() < last_sign + 120s) time.run_for(100ms);
  EXPECT_THAT(listener.take(), ElementsAre("a lost"));
  EXPECT_LE(time.now(), last_sign + 60s);
}

TEST_F(Distant, ManyTuplesArriveInFrames) {
  constexpr int kTuples = 20'000;
  for (int i = 0; i < kTuples; ++i) ASSERT_TRUE(island->space.set("a.t" + std::to_string(i), "x"));
  const auto handle = robot->space.subscribe(pattern("**"), {}, listener.call());
  time.run_for(1s);  // an engine may take only so much at once
  EXPECT_EQ(listener.seen.size(), static_cast<std::size_t>(kTuples));
  EXPECT_EQ(robot->space.stats().cached, static_cast<std::size_t>(kTuples));
}

TEST_F(Distant, AThousandBriefSubscriptionsLeaveNothingBehind) {
  for (int i = 0; i < 1000; ++i) {
    const auto handle = robot->space.subscribe(pattern("a.t" + std::to_string(i)), {}, listener.call());
    time.run_ready();
  }
  time.run_ready();
  EXPECT_EQ(robot->space.stats().subscriptions, 0u);
  EXPECT_EQ(island->space.stats().subscriptions, 0u);
}

}  // namespace
}  // namespace rubicon::tuples
