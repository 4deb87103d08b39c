#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

struct Alone : testing::Test {
  VirtualScheduler time;
  TestEcology ecology{time};
  Component me{ecology, time, 1};
  TupleSpace& space = me.space;
  Listener listener;
};

TEST_F(Alone, SequenceStartsAtOneAndGrowsWithEachSet) {
  const auto tuple = space.set("a.b", "1");
  ASSERT_TRUE(tuple);
  EXPECT_EQ(space.get(OwnerId(1), "a.b")->sequence, 1u);
  ASSERT_TRUE(space.set(*tuple, "1"));
  EXPECT_EQ(space.get(OwnerId(1), "a.b")->sequence, 2u);
  ASSERT_EQ(*space.set("a.b", "2"), *tuple);
  EXPECT_EQ(space.get(OwnerId(1), "a.b")->sequence, 3u);
}

TEST_F(Alone, ATupleCarriesWhatItWasSetWith) {
  const WallTime measured{5s};
  ASSERT_TRUE(space.set("a", "{}", {"application/json", measured, 10s}));
  const auto tuple = *space.get(OwnerId(1), "a");
  EXPECT_EQ(tuple.media_type, "application/json");
  EXPECT_EQ(tuple.user_time, measured);
  EXPECT_EQ(tuple.write_time, time.wall_now());
  EXPECT_EQ(tuple.expire_time, time.wall_now() + 10s);
  EXPECT_EQ(tuple.creator, OwnerId(1));
}

TEST_F(Alone, DeclareLeavesAPresentValueAlone) {
  const auto made = *space.declare("a");
  ASSERT_TRUE(space.set(made, "7"));
  EXPECT_EQ(*space.declare("a", "0"), made);
  EXPECT_EQ(space.get(OwnerId(1), "a")->value, "7");
}

TEST_F(Alone, EverySetIsSeenInOrderEqualValuesToo) {
  const auto handle = space.subscribe(pattern("*.b"), {}, listener.call());
  const auto tuple = *space.set("a.b", "1");
  ASSERT_TRUE(space.set(tuple, "1"));
  ASSERT_TRUE(space.set("c.b", "2"));
  ASSERT_TRUE(space.set("c.d", "unseen"));
  ASSERT_TRUE(space.set(tuple, std::string(100, 'x')));
  EXPECT_THAT(listener.seen, IsEmpty());
  time.run_ready();
  EXPECT_THAT(listener.seen, ElementsAre("a.b=1", "a.b=1", "c.b=2", "a.b=" + std::string(100, 'x')));
}

TEST_F(Alone, PresentTuplesAreToldAtOnce) {
  ASSERT_TRUE(space.set("a.b", "1"));
  ASSERT_TRUE(space.set("a.c", "2"));
  time.run_ready();
  const auto handle = space.subscribe(pattern("1:a.**"), {}, listener.call());
  EXPECT_THAT(listener.seen, IsEmpty());
  time.run_ready();
  EXPECT_THAT(listener.seen, testing::UnorderedElementsAre("a.b=1", "a.c=2"));
}

TEST_F(Alone, DeletionAndRecreationInOneTurnAreBothSeen) {
  const auto handle = space.subscribe(pattern("a"), {}, listener.call());
  const auto first = *space.set("a", "1");
  ASSERT_TRUE(space.erase("a"));
  const auto second = *space.set("a", "2");
  time.run_ready();
  EXPECT_THAT(listener.seen, ElementsAre("a=1", "a deleted", "a=2"));
  EXPECT_FALSE(first == second);
  EXPECT_EQ(space.set(first, "3").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(space.get(OwnerId(1), "a")->sequence, 1u);
}

TEST_F(Alone, AStaleShortNameDoesNotReachTheTupleThatTookItsPlace) {
  const auto first = *space.set("a", "1");
  ASSERT_TRUE(space.erase("a"));
  time.run_ready();
  ASSERT_TRUE(space.set("b", "2"));
  EXPECT_EQ(space.set(first, "3").error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(space.has_subscriber(first));
  EXPECT_EQ(space.get(OwnerId(1), "b")->value, "2");
}

TEST_F(Alone, ErasingByPatternTakesExactlyWhatMatches) {
  for (const auto* key : {"p.d1.s", "p.d1.s.v", "p.d2.s", "q.d1.s"}) ASSERT_TRUE(space.set(key, "x"));
  space.erase(pattern("7:p.**"));
  EXPECT_EQ(space.stats().own, 4u);
  space.erase(pattern("p.d1.**"));
  EXPECT_EQ(space.stats().own, 2u);
  EXPECT_TRUE(space.find("p.d2.s"));
  EXPECT_TRUE(space.find("q.d1.s"));
}

TEST_F(Alone, TuplesExpireOnTheDot) {
  const auto handle = space.subscribe(pattern("**"), {}, listener.call());
  ASSERT_TRUE(space.set("a", "1", {.lifetime = 10s}));
  ASSERT_TRUE(space.set("b", "1", {.lifetime = 5s}));
  time.run_for(5s - 1ns);
  EXPECT_THAT(listener.take(), ElementsAre("a=1", "b=1"));
  time.run_for(1ns);
  EXPECT_THAT(listener.take(), ElementsAre("b expired"));
  EXPECT_FALSE(space.find("b"));
  time.run_for(5s);
  EXPECT_THAT(listener.take(), ElementsAre("a expired"));
}

TEST_F(Alone, ASetRenewsOrEndsTheLifetime) {
  const auto a = *space.set("a", "1", {.lifetime = 10s});
  const auto b = *space.set("b", "1", {.lifetime = 10s});
  const auto c = *space.set("c", "1", {.lifetime = 10s});
  time.run_for(6s);
  ASSERT_TRUE(space.set(a, "2", {.lifetime = 10s}));
  ASSERT_TRUE(space.set(b, "2"));
  ASSERT_TRUE(space.set(c, "2", {.lifetime = 1s}));
  time.run_for(2s);
  EXPECT_FALSE(space.find("c"));
  time.run_for(7s);
  EXPECT_TRUE(space.find("a"));
  time.run_for(1s);
  EXPECT_FALSE(space.find("a"));
  time.run_for(1h);
  EXPECT_TRUE(space.find("b"));
}

TEST_F(Alone, AWallClockThatJumpsNeitherKillsNorKeepsATuple) {
  ASSERT_TRUE(space.set("a", "1", {.lifetime = 10s}));
  time.set_wall(time.wall_now() + 24h);
  time.run_for(9s);
  EXPECT_TRUE(space.find("a"));
  time.set_wall(time.wall_now() - 48h);
  time.run_for(1s);
  EXPECT_FALSE(space.find("a"));
}

TEST_F(Alone, TheWallClockIsReadInEachTurn) {
  const auto tuple = *space.set("a", "1");
  time.run_for(1s);
  ASSERT_TRUE(space.set(tuple, "2"));
  EXPECT_EQ(space.get(OwnerId(1), "a")->write_time, time.wall_now());
}

TEST_F(Alone, AVeryLongLifetimeDoesNotOverflow) {
  ASSERT_TRUE(space.set("a", "1", {.lifetime = Duration::max()}));
  time.run_for(24h);
  EXPECT_TRUE(space.find("a"));
}

TEST_F(Alone, NoCallAfterTheHandleIsGoneEvenWhenQueued) {
  auto handle = space.subscribe(pattern("a"), {}, listener.call());
  ASSERT_TRUE(space.set("a", "1"));
  handle.reset();
  time.run_ready();
  EXPECT_THAT(listener.seen, IsEmpty());
}

TEST_F(Alone, ACallbackMayEndItsOwnSubscription) {
  Handle handle;
  int calls = 0;
  auto token = std::make_shared<int>(7);
  const std::weak_ptr<int> captured = token;
  handle = space.subscribe(pattern("a"), {}, [&, token = std::move(token)](const Event&) {
    handle.reset();
    calls += *token;
  });
  ASSERT_TRUE(space.set("a", "1"));
  ASSERT_TRUE(space.set("a", "2"));
  time.run_ready();
  EXPECT_EQ(calls, 7);
  EXPECT_TRUE(captured.expired());
}

TEST_F(Alone, ACallbackMayEndTheOtherSubscription) {
  Handle first, second;
  int calls = 0;
  first = space.subscribe(pattern("a"), {}, [&](const Event&) { ++calls, second.reset(); });
  second = space.subscribe(pattern("a"), {}, [&](const Event&) { ++calls, first.reset(); });
  ASSERT_TRUE(space.set("a", "1"));
  time.run_ready();
  EXPECT_EQ(calls, 1);
}

TEST_F(Alone, ACallbackMaySetEraseAndSubscribe) {
  std::vector<Handle> handles;
  const auto watch = space.subscribe(pattern("a"), {}, [&](const Event& event) {
    if (event.kind != EventKind::kSet) return;
    handles.push_back(space.subscribe(pattern("**"), {}, listener.call()));
    for (int i = 0; i < 1000; ++i) ASSERT_TRUE(space.set("new.t" + std::to_string(i), "x"));
    ASSERT_TRUE(space.erase("a"));
    EXPECT_EQ(event.tuple.key, "a");
    EXPECT_EQ(event.tuple.value, "1");
  });
  ASSERT_TRUE(space.set("a", "1"));
  time.run_ready();
  EXPECT_EQ(listener.seen.size(), 1002u);
  EXPECT_THAT(listener.seen, testing::Contains("a deleted"));
}

TEST_F(Alone, HandlesMayOutliveTheSpace) {
  Handle subscription, watch, policy, peers;
  {
    Component other(ecology, time, 2);
    subscription = other.space.subscribe(pattern("**"), {}, listener.call());
    watch = other.space.watch_demand(pattern("**"), [](const Demand&) {});
    policy = other.space.add_policy(pattern("**"), [](const RemoteSet&) { return SetDecision::applied(); });
    peers = other.space.watch_peers([](OwnerId, PeerEvent) {});
    ASSERT_TRUE(other.space.set("a", "1"));
  }
  time.run_ready();
  subscription.reset();
  EXPECT_THAT(listener.seen, IsEmpty());
}

TEST_F(Alone, HostileKeysAreRefused) {
  for (const std::string& key : {std::string(""), std::string("a..b"), std::string(".a"), std::string("a/b"),
                                 std::string("a\nb"), std::string("a.*"), std::string("**"), std::string("\xc3\xa4"),
                                 std::string(10240, 'k'), std::string("a\0b", 3)}) {
    const auto set = space.set(key, "1");
    ASSERT_FALSE(set) << key;
    EXPECT_EQ(set.error().code, ErrorCode::kInvalid);
    EXPECT_FALSE(space.find(key));
    EXPECT_FALSE(space.erase(key));
    EXPECT_FALSE(space.get(OwnerId(1), key));
  }
  EXPECT_EQ(space.stats().own, 0u);
}

TEST_F(Alone, HugeValuesAreRefused) {
  const auto tuple = *space.set("a", "1");
  const std::string huge(1024 * 1024 + 1, 'x');
  EXPECT_EQ(space.set("a", huge).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(space.set(tuple, huge).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(space.get(OwnerId(1), "a")->value, "1");
}

TEST_F(Alone, UnsoundPatternsMatchNothing) {
  ASSERT_TRUE(space.set("a", "1"));
  for (const auto* key : {"", "a..b", "**.a", "7:a", "a b"}) {
    EXPECT_FALSE(space.subscribe({std::nullopt, key}, {}, listener.call()));
    space.erase({std::nullopt, key});
    space.list({std::nullopt, key}, [](const TupleView&) { FAIL(); });
  }
  EXPECT_EQ(space.stats().own, 1u);
}

TEST_F(Alone, ListVisitsWhatMatchesAndMayEraseIt) {
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(space.set("a.t" + std::to_string(i), "x"));
  ASSERT_TRUE(space.set("b", "x"));
  int visited = 0;
  space.list(pattern("a.*"), [&](const TupleView& tuple) {
    ++visited;
    ASSERT_TRUE(space.erase(std::string(tuple.key)));
  });
  EXPECT_EQ(visited, 50);
  EXPECT_EQ(space.stats().own, 1u);
}

TEST_F(Alone, LongWalksTakeSeveralTurnsAndMissNothing) {
  constexpr int kTuples = 60'000;
  for (int i = 0; i < kTuples; ++i) ASSERT_TRUE(space.set("a.t" + std::to_string(i), "x"));
  time.run_ready();
  std::size_t seen = 0, deleted = 0;
  const auto handle = space.subscribe(pattern("a.**"), {},
                                      [&](const Event& event) { ++(event.kind == EventKind::kSet ? seen : deleted); });
  ASSERT_TRUE(space.set("a.late", "x"));
  time.run_ready();
  EXPECT_EQ(seen, kTuples + 1u);
  space.erase(pattern("a.*"));
  EXPECT_GT(space.stats().own, 0u);
  EXPECT_FALSE(space.find("a.t7"));
  EXPECT_FALSE(space.find("a.t50000"));
  ASSERT_TRUE(space.set("a.t7", "born after"));
  time.run_ready();
  EXPECT_EQ(space.stats().own, 1u);
  EXPECT_EQ(space.get(OwnerId(1), "a.t7")->value, "born after");
  EXPECT_EQ(deleted, kTuples + 1u);
}

}  // namespace
}  // namespace rubicon::tuples
