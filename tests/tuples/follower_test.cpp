#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tuples/references.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Following : MetaTuples {
  Handle follow(const TupleName& name, const Flow& flow = {}) {
    return subscribe_through(robot->space, name, flow, events.call(), [this](const Result<TupleName>& target) {
      targets.push_back(target ? to_string(*target) : std::string(to_string(target.error().code)));
    });
  }
  Seen turn() {
    time.run_ready();
    return events.take();
  }
  Listener events;
  Seen targets;
};

TEST_F(Following, ASubscriptionMovesWithTheReference) {
  ASSERT_TRUE(island->space.set("one", "1"));
  ASSERT_TRUE(island->space.set("two", "2"));
  link("best", here("one"));
  const auto handle = follow(there("best"));
  EXPECT_THAT(events.take(), IsEmpty()) << "never inside the call";
  EXPECT_THAT(turn(), ElementsAre("one=1"));
  ASSERT_TRUE(island->space.set("one", "1b"));
  ASSERT_TRUE(island->space.set("two", "2b"));
  EXPECT_THAT(turn(), ElementsAre("one=1b"));
  link("best", here("two"));
  EXPECT_THAT(turn(), ElementsAre("two=2b")) << "the present value; a move deletes nothing";
  ASSERT_TRUE(island->space.set("one", "1c"));
  ASSERT_TRUE(island->space.set("two", "2c"));
  EXPECT_THAT(turn(), ElementsAre("two=2c"));
  EXPECT_THAT(targets, ElementsAre("1:one", "1:two"));
  EXPECT_FALSE(robot->space.get(kIsland, "one")) << "no copy is kept of what is not followed any more";
}

TEST_F(Following, DemandMovesWithTheReference) {
  ASSERT_TRUE(island->space.declare("one"));
  ASSERT_TRUE(island->space.declare("two"));
  Seen demand;
  const auto watch = island->space.watch_demand(pattern("*"), [&](const Demand& now) {
    demand.push_back(std::string(now.key) + (now.wanted ? " on " : " off ") + std::to_string(now.interval / 1ms));
  });
  link("best", here("one"));
  auto handle = follow(there("best"), {.minimum = 2s});
  time.run_ready();
  EXPECT_THAT(std::exchange(demand, {}), ElementsAre("one on 2000"));
  link("best", here("two"));
  time.run_ready();
  EXPECT_THAT(std::exchange(demand, {}), testing::UnorderedElementsAre("one off 0", "two on 2000"));
  handle.reset();
  time.run_ready();
  EXPECT_THAT(demand, ElementsAre("two off 0"));
}

TEST_F(Following, NobodyWantsAMetaTupleForFollowingIt) {
  point(island->space, "meta", here("light"));
  ASSERT_TRUE(island->space.declare("light"));
  Seen wanted;
  const auto watch = island->space.watch_demand(pattern("*"), [&](const Demand& now) {
    if (now.wanted) wanted.emplace_back(now.key);
  });
  const auto handle = follow(here("meta"));
  time.run_ready();
  EXPECT_THAT(wanted, ElementsAre("light"));
}

TEST_F(Following, FlowControlHoldsForTheTarget) {
  ASSERT_TRUE(island->space.set("light", "0"));
  link("best", here("light"));
  const auto handle = follow(there("best"), {.minimum = 10s, .maximum = 20s});
  for (int i = 0; i < 25; ++i) {
    ASSERT_TRUE(island->space.set("light", std::to_string(i)));
    time.run_for(1s);
  }
  EXPECT_THAT(events.take(), ElementsAre("light=0", "light=9", "light=19"));
  time.run_for(26s);
  EXPECT_THAT(events.take(), ElementsAre("light=24", "light=24"));
}

TEST_F(Following, ADeletedMetaTupleIsToldOnceAndTakenUpAgain) {
  ASSERT_TRUE(island->space.set("light", "5"));
  link("best", here("light"));
  const auto handle = follow(there("best"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  ASSERT_TRUE(robot->space.erase("best"));
  EXPECT_THAT(turn(), ElementsAre("light deleted"));
  ASSERT_TRUE(island->space.erase("light"));
  EXPECT_THAT(turn(), IsEmpty());
  ASSERT_TRUE(island->space.set("light", "6"));
  link("best", here("light"));
  EXPECT_THAT(turn(), ElementsAre("light=6"));
  EXPECT_THAT(targets, ElementsAre("1:light", "not-found", "1:light"));
}

TEST_F(Following, ADeletedTargetIsToldOnceWithItsLastValue) {
  ASSERT_TRUE(island->space.set("light", "5"));
  link("best", here("light"));
  std::vector<std::string> ends;
  const auto handle = subscribe_through(robot->space, there("best"), {}, [&](const Event& event) {
    if (event.kind != EventKind::kSet)
      ends.push_back(to_string(event.kind).data() + (":" + std::string(event.tuple.value)));
  });
  time.run_ready();
  ASSERT_TRUE(island->space.erase("light"));
  time.run_ready();
  ASSERT_TRUE(robot->space.erase("best"));
  time.run_ready();
  EXPECT_THAT(ends, ElementsAre("deleted:5"));
  ASSERT_TRUE(island->space.set("light", "6"));
  link("best", here("light"));
  time.run_ready();
  ASSERT_TRUE(robot->space.erase("best"));
  time.run_ready();
  EXPECT_THAT(ends, ElementsAre("deleted:5", "deleted:6")) << "with the value, though it is the meta tuple that went";
}

TEST_F(Following, AnExpiredMetaTupleEndsItsValueAsExpired) {
  ASSERT_TRUE(island->space.set("light", "5"));
  ASSERT_TRUE(robot->space.set("best", "1:light", {.media_type = kReferenceMediaType, .lifetime = 10s}));
  const auto handle = follow(there("best"));
  time.run_for(11s);
  EXPECT_THAT(events.take(), ElementsAre("light=5", "light expired"));
}

TEST_F(Following, AMetaTupleMadeAgainInTheSameTurnTellsTheValueAgain) {
  ASSERT_TRUE(island->space.set("light", "5"));
  link("best", here("light"));
  const auto handle = follow(there("best"));
  turn();
  ASSERT_TRUE(robot->space.erase("best"));
  link("best", here("light"));
  EXPECT_THAT(turn(), ElementsAre("light deleted", "light=5"));
  ASSERT_TRUE(island->space.set("light", "6"));
  EXPECT_THAT(turn(), ElementsAre("light=6"));
}

TEST_F(Following, WhatComesLaterIsFollowedFromThen) {
  const auto handle = follow(there("best"));
  EXPECT_THAT(turn(), IsEmpty());
  link("best", here("light"));
  EXPECT_THAT(turn(), IsEmpty());
  ASSERT_TRUE(island->space.set("light", "5"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
}

TEST_F(Following, AChainAcrossComponentsIsFollowedAtEveryLink) {
  Component third{ecology, time, 80000};
  ASSERT_TRUE(island->space.set("light", "5"));
  ASSERT_TRUE(island->space.set("dark", "0"));
  point(island->space, "inner", here("light"));
  ASSERT_TRUE(set_reference(third.space, "outer", here("inner")));
  const auto handle = follow({OwnerId(80000), "outer"});
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  point(island->space, "inner", here("dark"));
  EXPECT_THAT(turn(), ElementsAre("dark=0"));
  ASSERT_TRUE(set_reference(third.space, "outer", here("light")));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  ASSERT_TRUE(set_reference(third.space, "outer", here("inner")));
  EXPECT_THAT(turn(), ElementsAre("dark=0"));
  ASSERT_TRUE(island->space.erase("inner"));
  EXPECT_THAT(turn(), ElementsAre("dark deleted"));
  point(island->space, "inner", here("light"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  EXPECT_EQ(robot->space.stats().subscriptions, 3u);
}

TEST_F(Following, ATargetThatBecomesAMetaTupleIsFollowedAndBack) {
  ASSERT_TRUE(island->space.set("light", "5"));
  ASSERT_TRUE(island->space.set("inner", "plain"));
  link("best", here("inner"));
  const auto handle = follow(there("best"));
  EXPECT_THAT(turn(), ElementsAre("inner=plain"));
  point(island->space, "inner", here("light"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  ASSERT_TRUE(island->space.set("inner", "plain"));
  EXPECT_THAT(turn(), ElementsAre("inner=plain"));
  EXPECT_THAT(targets, ElementsAre("1:inner", "1:light", "1:inner"));
}

TEST_F(Following, ACycleThatComesLaterIsToldAndMended) {
  ASSERT_TRUE(island->space.set("light", "5"));
  point(island->space, "inner", here("light"));
  link("best", here("inner"));
  Seen whys;
  const auto handle = subscribe_through(robot->space, there("best"), {}, events.call(), [&](const auto& target) {
    whys.push_back(target ? to_string(*target) : target.error().text);
  });
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  point(island->space, "inner", there("best"));
  EXPECT_THAT(turn(), ElementsAre("light deleted"));
  EXPECT_THAT(whys, ElementsAre("1:inner", "1:light", HasSubstr("cycle 70000:best -> 1:inner -> 70000:best")))
      << "inner counts as the target until it is seen";
  const auto before = robot->space.stats().events;
  time.run_for(1h);
  EXPECT_EQ(robot->space.stats().events, before) << "a cycle costs nothing while it lasts";
  point(island->space, "inner", here("light"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  link("best", here("light"));
  EXPECT_THAT(turn(), ElementsAre("light=5")) << "the same target, by a new subscription";
}

TEST_F(Following, AReferenceThatCannotBeReadIsToldAndMended) {
  ASSERT_TRUE(island->space.set("light", "5"));
  ASSERT_TRUE(robot->space.set("best", "somewhere", {.media_type = kReferenceMediaType}));
  const auto handle = follow(there("best"));
  EXPECT_THAT(turn(), IsEmpty());
  link("best", here("light"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  ASSERT_TRUE(robot->space.set("best", "now a value"));
  EXPECT_THAT(turn(), ElementsAre("light deleted"));
  ASSERT_TRUE(robot->space.set("best", "(META 1 light)", {.media_type = kPeisReferenceMediaType}));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
  EXPECT_THAT(targets, ElementsAre("invalid", "1:light", "invalid", "1:light"));
}

TEST_F(Following, AThousandChangesInATurnAreOneMove) {
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(island->space.set("t" + std::to_string(i), std::to_string(i)));
  const auto handle = follow(there("best"));
  for (int i = 0; i < 1000; ++i) link("best", here("t" + std::to_string(i)));
  EXPECT_THAT(turn(), ElementsAre("t999=999"));
  EXPECT_THAT(targets, ElementsAre("1:t999"));
  EXPECT_EQ(robot->space.stats().subscriptions, 2u);
}

TEST_F(Following, TheLossOfAnOwnerTellsNothingAndItsReturnWhatChanged) {
  ASSERT_TRUE(island->space.set("one", "1"));
  ASSERT_TRUE(island->space.set("two", "2"));
  point(island->space, "meta", here("one"));
  const auto handle = follow(here("meta"));
  EXPECT_THAT(turn(), ElementsAre("one=1"));
  ecology.cut(kIsland, kRobot);
  EXPECT_THAT(turn(), IsEmpty());
  point(island->space, "meta", here("two"));
  ecology.mend(kIsland, kRobot);
  EXPECT_THAT(turn(), ElementsAre("two=2"));
}

TEST_F(Following, AHandleMayEndInsideAnyOfItsCalls) {
  ASSERT_TRUE(island->space.set("light", "5"));
  for (int ends_in = 0; ends_in < 4; ++ends_in) {
    link("best", here("light"));
    Handle handle;
    int calls = 0;
    const auto end_at = [&](int call) {
      ++calls;
      if (call == ends_in) handle.reset();
    };
    handle = subscribe_through(
        robot->space, there("best"), {}, [&](const Event& event) { end_at(event.kind == EventKind::kSet ? 1 : 2); },
        [&](const Result<TupleName>& target) { end_at(target ? 0 : 3); });
    time.run_ready();
    ASSERT_TRUE(robot->space.erase("best"));
    time.run_ready();
    EXPECT_EQ(calls, ends_in + 1);
    EXPECT_FALSE(handle);
    EXPECT_EQ(robot->space.stats().subscriptions, 0u);
    EXPECT_EQ(robot->space.stats().cached, 0u);
  }
}

TEST_F(Following, CallsMayTurnTheReference) {
  ASSERT_TRUE(island->space.set("one", "1"));
  ASSERT_TRUE(island->space.set("two", "2"));
  link("best", here("one"));
  const auto handle = subscribe_through(robot->space, there("best"), {}, [&](const Event& event) {
    events.call()(event);
    if (event.tuple.key == "one") link("best", here("two"));
  });
  EXPECT_THAT(turn(), ElementsAre("one=1", "two=2"));
}

TEST_F(Following, AHandleMayOutliveTheSpace) {
  ASSERT_TRUE(island->space.set("light", "5"));
  point(island->space, "meta", here("light"));
  auto handle = follow(here("meta"));
  time.run_ready();
  robot.reset();
  handle.reset();
  ASSERT_TRUE(island->space.set("light", "6"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
}

/// Values and references made, turned and erased at random, by two owners; a third follows one of them and sees
/// nothing else, a fourth sees all and says what is right.
struct RandomReferences {
  RandomReferences() {
    handle = subscribe_through(
        follower.space, meta, {},
        [this](const Event& event) {
          const TupleName name{event.tuple.owner, std::string(event.tuple.key)};
          told = event.kind == EventKind::kSet ? to_string(name) + "=" + std::string(event.tuple.value) : "";
        },
        [this](const Result<TupleName>& now) { target = now ? to_string(*now) : ""; });
  }

  std::size_t roll(std::size_t sides) { return std::uniform_int_distribution<std::size_t>(0, sides - 1)(dice); }
  TupleName name() { return {roll(2) == 0 ? two.kIsland : two.kRobot, std::string(1, "abc"[roll(3)])}; }

  void step() {
    const auto at = name();
    auto& space = at.owner == two.kIsland ? two.island->space : two.robot->space;
    const auto choice = roll(10);
    if (choice < 4) {
      ASSERT_TRUE(space.set(at.key, std::to_string(++values)));
    } else if (choice < 8) {
      ASSERT_TRUE(space.set(at.key, to_string(name()), {.media_type = kReferenceMediaType}));
    } else {
      static_cast<void>(space.erase(at.key));
    }
    if (roll(20) == 0) two.ecology.cut(two.kIsland, OwnerId(80000));
    if (roll(10) == 0) two.ecology.mend(two.kIsland, OwnerId(80000));
  }

  void check() {
    two.ecology.mend(two.kIsland, OwnerId(80000));
    two.time.run_ready();
    const auto right = resolve(observer.space, meta);
    if (!right && !observer.space.get(meta.owner, meta.key) && target == "none yet") return;
    EXPECT_EQ(target, right ? to_string(*right) : "");
    if (!right) {
      EXPECT_EQ(told, "");
    } else if (const auto tuple = observer.space.get(right->owner, right->key)) {
      EXPECT_EQ(told, to_string(*right) + "=" + std::string(tuple->value));
    }
  }

  TwoComponents two;
  Component follower{two.ecology, two.time, 80000};
  Component observer{two.ecology, two.time, 90000};
  Handle sees = observer.space.subscribe(pattern("**"), {.passive = true}, [](const Event&) {});
  std::mt19937 dice{20260401};
  const TupleName meta{OwnerId(1), "a"};
  int values = 0;
  std::string told, target = "none yet";
  Handle handle;
};

TEST(ReferencesAtRandom, AFollowerAlwaysEndsWhereTheReferencesLead) {
  RandomReferences random;
  for (int i = 0; i < 20'000; ++i) {
    random.step();
    if (random.roll(3) == 0) random.two.time.run_ready();
    if (i % 5 != 0) continue;
    random.check();
    ASSERT_FALSE(testing::Test::HasFailure()) << "after step " << i;
  }
  random.handle.reset();
  random.two.time.run_ready();
  EXPECT_EQ(random.follower.space.stats().subscriptions, 1u) << "that of the observer";
  EXPECT_EQ(random.follower.space.stats().cached, 0u);
}

}  // namespace
}  // namespace rubicon::tuples
