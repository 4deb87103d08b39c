#include "tuples/meta_tuple.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(References, AreReadInOurSpelling) {
  const auto name = read_reference(kReferenceMediaType, "6541:proxy.dummy-1.1.sensor.light-1.value");
  ASSERT_TRUE(name);
  EXPECT_EQ(*name, (TupleName{OwnerId(6541), "proxy.dummy-1.1.sensor.light-1.value"}));
  EXPECT_EQ(read_reference(kReferenceMediaType, to_string(*name)), *name);
}

TEST(References, AreReadInTheSpellingOfPeis) {
  const TupleName expected{OwnerId(101), "demo.temp.value"};
  EXPECT_EQ(read_reference(kPeisReferenceMediaType, "(META 101 demo.temp.value)"), expected);
  EXPECT_EQ(read_reference(kPeisReferenceMediaType, std::string_view("(META 101 demo.temp.value)\0", 27)), expected);
  EXPECT_EQ(read_reference(kPeisReferenceMediaType, "(META -1 NULL)").error().code, ErrorCode::kNotFound);
}

TEST(References, ThatAreNoneAreRefused) {
  for (const auto* text : {"a.b", "0:a", "*:a", "1:*", "1:a.**", "1:", ":a", "1:a b", " 1:a", "1:a\n", "-1:a", "+1:a",
                           "4294967296:a", "1:2:a", "1:a..b", "(META 1 a)"}) {
    EXPECT_EQ(read_reference(kReferenceMediaType, text).error().code, ErrorCode::kInvalid) << text;
  }
  for (const auto* text : {"", "(", ")", "(META", "(META )", "(META 1)", "(META 1 )", "(META  1 a)", "(META 1  a)",
                           "(META 1 a", "(META -1 a)", "(META 0 a)", "(META 1 *)", "(meta 1 a)", "1:a"}) {
    EXPECT_EQ(read_reference(kPeisReferenceMediaType, text).error().code, ErrorCode::kInvalid) << text;
  }
  EXPECT_EQ(read_reference(kReferenceMediaType, "").error().code, ErrorCode::kNotFound);
  const auto plain = read_reference("text/plain", "1:a");
  EXPECT_EQ(plain.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(plain.error().text, HasSubstr("not a meta tuple"));
}

/// The island owns targets, the robot meta tuples.
struct MetaTuples : testing::Test, TwoComponents {
  TupleName here(std::string key) const { return {kIsland, std::move(key)}; }
  TupleName there(std::string key) const { return {kRobot, std::move(key)}; }
  /// Sets a reference without asking whether it makes sense.
  void point(TupleSpace& space, std::string_view key, const TupleName& target) {
    ASSERT_TRUE(space.set(key, to_string(target), {.media_type = kReferenceMediaType}));
  }
  void link(std::string_view key, const TupleName& target) {
    const auto ok = set_reference(robot->space, key, target);
    ASSERT_TRUE(ok) << ok.error().text;
  }
  Handle see(std::string_view keys) {
    return robot->space.subscribe(pattern(keys), {.passive = true}, [](const Event&) {});
  }
  Handle follow(const TupleName& meta, const Flow& flow = {}) {
    return subscribe_through(robot->space, meta, flow, events.call(), note_targets());
  }
  TargetCall note_targets() {
    return [this](const Result<TupleName>& target) {
      targets.push_back(target ? to_string(*target) : std::string(to_string(target.error().code)));
    };
  }
  Seen turn() {
    time.run_ready();
    return events.take();
  }
  Listener events;
  Seen targets;
};

TEST_F(MetaTuples, LeadToTheirTarget) {
  ASSERT_TRUE(island->space.set("light", "5"));
  const auto seen = see("1:**");
  time.run_ready();
  link("best", here("light"));
  EXPECT_EQ(robot->space.get(kRobot, "best")->value, "1:light");
  EXPECT_EQ(robot->space.get(kRobot, "best")->media_type, kReferenceMediaType);
  EXPECT_EQ(resolve(robot->space, there("best")), here("light"));
  EXPECT_EQ(get_through(robot->space, there("best"))->value, "5");
  link("better", there("best"));
  EXPECT_EQ(resolve(robot->space, there("better")), here("light")) << "a chain";
}

TEST_F(MetaTuples, SayWhyTheyLeadNowhere) {
  EXPECT_EQ(resolve(robot->space, there("none")).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(robot->space.set("plain", "1:light"));
  EXPECT_EQ(resolve(robot->space, there("plain")).error().code, ErrorCode::kInvalid);
  ASSERT_TRUE(robot->space.set("empty", "", {.media_type = kReferenceMediaType}));
  EXPECT_EQ(resolve(robot->space, there("empty")).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(robot->space.set("broken", "light", {.media_type = kReferenceMediaType}));
  link("outer", there("broken"));
  const auto broken = resolve(robot->space, there("outer"));
  EXPECT_EQ(broken.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(broken.error().text, HasSubstr("70000:outer at 70000:broken"));
  link("dangling", there("nothing"));
  EXPECT_EQ(resolve(robot->space, there("dangling")), there("nothing"));
  EXPECT_EQ(get_through(robot->space, there("dangling")).error().code, ErrorCode::kNotFound);
}

TEST_F(MetaTuples, RefuseCyclesByName) {
  link("a", there("b"));
  link("b", there("c"));
  const auto refused = set_reference(robot->space, "c", there("a"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_THAT(refused.error().text, HasSubstr("cycle 70000:c -> 70000:a -> 70000:b -> 70000:c"));
  EXPECT_FALSE(robot->space.find("c"));
  EXPECT_THAT(set_reference(robot->space, "self", there("self")).error().text,
              HasSubstr("cycle 70000:self -> 70000:self"));

  point(robot->space, "c", there("b"));
  const auto found = resolve(robot->space, there("a"));
  EXPECT_EQ(found.error().code, ErrorCode::kRefused);
  EXPECT_THAT(found.error().text, HasSubstr("meta tuple 70000:a: cycle 70000:b -> 70000:c -> 70000:b"));
}

TEST_F(MetaTuples, FollowEightReferencesAndNoMore) {
  ASSERT_TRUE(robot->space.set("m8", "end"));
  for (int i = 7; i >= 0; --i) link("m" + std::to_string(i), there("m" + std::to_string(i + 1)));
  EXPECT_EQ(resolve(robot->space, there("m0")), there("m8"));
  const auto refused = set_reference(robot->space, "ninth", there("m0"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutOfRange);
  point(robot->space, "ninth", there("m0"));
  EXPECT_EQ(resolve(robot->space, there("ninth")).error().code, ErrorCode::kOutOfRange);
}

TEST_F(MetaTuples, RefuseImpossibleNames) {
  EXPECT_EQ(set_reference(robot->space, "a..b", here("x")).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(set_reference(robot->space, "a", here("x.*")).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(set_reference(robot->space, "a", {OwnerId(0), "x"}).error().code, ErrorCode::kInvalid);
  EXPECT_FALSE(set_reference(robot->space, here("*"), here("x"), 1s, {}));
  EXPECT_FALSE(robot->space.find("a"));
  EXPECT_FALSE(subscribe_through(robot->space, there("*"), {}, events.call()));
}

TEST_F(MetaTuples, OfOthersAreSetThroughTheirJudge) {
  const auto seen = see("1:**");
  const auto judge = island->space.judge(pattern("best"), [](const RemoteSet& wish) {
    return is_reference(wish.media_type) ? Judgement::applied() : Judgement::refused({ErrorCode::kInvalid, "no"});
  });
  std::vector<Verdict> verdicts;
  ASSERT_TRUE(set_reference(robot->space, here("best"), here("light"), 1s,
                            [&](const Reply& reply) { verdicts.push_back(reply.verdict); }));
  time.run_ready();
  EXPECT_THAT(verdicts, ElementsAre(Verdict::kApplied));
  EXPECT_EQ(resolve(robot->space, here("best")), here("light"));
  EXPECT_EQ(set_reference(robot->space, here("best"), here("best"), 1s, {}).error().code, ErrorCode::kRefused);
}

TEST_F(MetaTuples, SetAndAppendThroughAskTheOwnerOfTheTarget) {
  const auto seen = see("1:**");
  ASSERT_TRUE(island->space.set("lamp", "off"));
  const auto judge = island->space.judge(
      pattern("lamp"), [](const RemoteSet&) { return Judgement::applied(); }, Accepts::kSetsAndAppends);
  link("best", here("lamp"));
  time.run_ready();
  Seen verdicts;
  const auto note = [&](const Reply& reply) { verdicts.push_back(std::string(to_string(reply.verdict))); };
  ASSERT_TRUE(set_through(robot->space, there("best"), "on", 1s, note));
  time.run_ready();
  EXPECT_EQ(island->space.get(kIsland, "lamp")->value, "on");
  EXPECT_EQ(island->space.get(kIsland, "lamp")->creator, kRobot);
  ASSERT_TRUE(append_through(robot->space, there("best"), "!", 1s, note, {.expected_sequence = 2}));
  ASSERT_TRUE(append_through(robot->space, there("best"), "?", 1s, note, {.expected_sequence = 2}));
  time.run_ready();
  EXPECT_EQ(island->space.get(kIsland, "lamp")->value, "on!");
  EXPECT_THAT(verdicts, ElementsAre("applied", "applied", "refused"));
  EXPECT_EQ(robot->space.get(kRobot, "best")->value, "1:lamp");
}

TEST_F(MetaTuples, AnOwnTargetIsJudgedLikeAnyOther) {
  ASSERT_TRUE(robot->space.set("mode", "idle"));
  link("best", there("mode"));
  std::vector<ErrorCode> codes;
  const auto note = [&](const Reply& reply) { codes.push_back(reply.code); };
  ASSERT_TRUE(set_through(robot->space, there("best"), "busy", 1s, note));
  time.run_ready();
  EXPECT_THAT(codes, ElementsAre(ErrorCode::kRefused)) << "nobody judges it";
  const auto judge = robot->space.judge(pattern("mode"), [](const RemoteSet&) { return Judgement::applied(); });
  ASSERT_TRUE(set_through(robot->space, there("best"), "busy", 1s, note));
  time.run_ready();
  EXPECT_EQ(get_through(robot->space, there("best"))->value, "busy");
}

TEST_F(MetaTuples, NothingIsSetThroughToATargetThatIsNotSeen) {
  ASSERT_TRUE(island->space.set("inner", "1:lamp", {.media_type = kReferenceMediaType}));
  const auto judge = island->space.judge(pattern("**"), [](const RemoteSet&) { return Judgement::applied(); });
  link("outer", here("inner"));
  const auto blind = set_through(robot->space, there("outer"), "on", 1s, {});
  ASSERT_FALSE(blind) << "would overwrite the reference";
  EXPECT_EQ(blind.error().code, ErrorCode::kNotFound);
  const auto seen = see("1:**");
  time.run_ready();
  ASSERT_TRUE(island->space.set("lamp", "off"));
  time.run_ready();
  ASSERT_TRUE(set_through(robot->space, there("outer"), "on", 1s, {}));
  time.run_ready();
  EXPECT_EQ(island->space.get(kIsland, "lamp")->value, "on");
  EXPECT_EQ(island->space.get(kIsland, "inner")->value, "1:lamp");
}

TEST_F(MetaTuples, ASubscriptionMovesWithTheReference) {
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

TEST_F(MetaTuples, DemandMovesWithTheReference) {
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

TEST_F(MetaTuples, NobodyWantsAMetaTupleForFollowingIt) {
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

TEST_F(MetaTuples, FlowControlHoldsForTheTarget) {
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

TEST_F(MetaTuples, ADeletedMetaTupleIsToldOnceAndTakenUpAgain) {
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

TEST_F(MetaTuples, ADeletedTargetIsToldOnceWithItsLastValue) {
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

TEST_F(MetaTuples, AnExpiredMetaTupleEndsItsValueAsExpired) {
  ASSERT_TRUE(island->space.set("light", "5"));
  ASSERT_TRUE(robot->space.set("best", "1:light", {.media_type = kReferenceMediaType, .lifetime = 10s}));
  const auto handle = follow(there("best"));
  time.run_for(11s);
  EXPECT_THAT(events.take(), ElementsAre("light=5", "light expired"));
}

TEST_F(MetaTuples, AMetaTupleMadeAgainInTheSameTurnTellsTheValueAgain) {
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

TEST_F(MetaTuples, WhatComesLaterIsFollowedFromThen) {
  const auto handle = follow(there("best"));
  EXPECT_THAT(turn(), IsEmpty());
  link("best", here("light"));
  EXPECT_THAT(turn(), IsEmpty());
  ASSERT_TRUE(island->space.set("light", "5"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
}

TEST_F(MetaTuples, AChainAcrossComponentsIsFollowedAtEveryLink) {
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

TEST_F(MetaTuples, ATargetThatBecomesAMetaTupleIsFollowedAndBack) {
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

TEST_F(MetaTuples, ACycleThatComesLaterIsToldAndMended) {
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

TEST_F(MetaTuples, AReferenceThatCannotBeReadIsToldAndMended) {
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

TEST_F(MetaTuples, AThousandChangesInATurnAreOneMove) {
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(island->space.set("t" + std::to_string(i), std::to_string(i)));
  const auto handle = follow(there("best"));
  for (int i = 0; i < 1000; ++i) link("best", here("t" + std::to_string(i)));
  EXPECT_THAT(turn(), ElementsAre("t999=999"));
  EXPECT_THAT(targets, ElementsAre("1:t999"));
  EXPECT_EQ(robot->space.stats().subscriptions, 2u);
}

TEST_F(MetaTuples, TheLossOfAnOwnerTellsNothingAndItsReturnWhatChanged) {
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

TEST_F(MetaTuples, AHandleMayEndInsideAnyOfItsCalls) {
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

TEST_F(MetaTuples, CallsMayTurnTheReference) {
  ASSERT_TRUE(island->space.set("one", "1"));
  ASSERT_TRUE(island->space.set("two", "2"));
  link("best", here("one"));
  const auto handle = subscribe_through(robot->space, there("best"), {}, [&](const Event& event) {
    events.call()(event);
    if (event.tuple.key == "one") link("best", here("two"));
  });
  EXPECT_THAT(turn(), ElementsAre("one=1", "two=2"));
}

TEST_F(MetaTuples, AHandleMayOutliveTheSpace) {
  ASSERT_TRUE(island->space.set("light", "5"));
  point(island->space, "meta", here("light"));
  auto handle = follow(here("meta"));
  time.run_ready();
  robot.reset();
  handle.reset();
  ASSERT_TRUE(island->space.set("light", "6"));
  EXPECT_THAT(turn(), ElementsAre("light=5"));
}

}  // namespace
}  // namespace rubicon::tuples
