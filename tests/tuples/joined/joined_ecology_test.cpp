#include "tuples/joined/joined_ecology.h"

#include "tuples/joined/two_engines.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::joined {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr OwnerId kHome{1}, kBot{70000};

TEST_F(TwoEngines, OfferOwnTuplesAndPoliciesOnBoth) {
  const auto island = join(both, 1), native = join(dds, 2), kernel = join(peis, 3);
  ASSERT_TRUE(island->space.set("lamp", "off"));
  const auto policy =
      island->space.add_policy(pattern("lamp"), [](const RemoteSet&) { return SetDecision::applied(); });
  Listener on_dds, on_peis;
  const auto one = native->space.subscribe(pattern("1:lamp"), {}, on_dds.call());
  const auto other = kernel->space.subscribe(pattern("*:lamp"), {}, on_peis.call());
  time.run_ready();
  EXPECT_EQ(native->set(time, 1, "lamp", "on").verdict, Verdict::kApplied);
  EXPECT_EQ(kernel->set(time, 1, "lamp", "dim").verdict, Verdict::kApplied);
  for (const auto* seen : {&on_dds, &on_peis}) EXPECT_THAT(seen->seen, ElementsAre("lamp=off", "lamp=on", "lamp=dim"));
  EXPECT_EQ(island->space.get(kHome, "lamp")->creator, OwnerId(3));
}

TEST_F(TwoEngines, HaveEachOwnerWhereItWasMet) {
  const auto island = join(both, 1), native = join(dds, 2), kernel = join(peis, 3);
  EXPECT_THAT(island->space.peers(), ElementsAre(OwnerId(2), OwnerId(3)));
  std::vector<Handle> policies;
  for (const auto* owner : {&native, &kernel}) {
    auto& space = (*owner)->space;
    ASSERT_TRUE(space.set("x", "0"));
    policies.push_back(space.add_policy(pattern("x"), [](const RemoteSet&) { return SetDecision::applied(); }));
  }
  Listener seen;
  std::vector<OwnerId> ends;
  const auto handle = island->space.subscribe(pattern("*:x"), {}, seen.call(), [&](OwnerId o) { ends.push_back(o); });
  time.run_ready();
  EXPECT_THAT(ends, ElementsAre(OwnerId(2), OwnerId(3)));
  EXPECT_EQ(island->set(time, 2, "x", "2").verdict, Verdict::kApplied);
  EXPECT_EQ(island->set(time, 3, "x", "3").verdict, Verdict::kApplied);
  EXPECT_EQ(island->value(2, "x") + island->value(3, "x"), "23");
  EXPECT_EQ(island->set(time, 4, "x", "4").verdict, Verdict::kNoSuchOwner);
  EXPECT_THAT(native->space.peers(), ElementsAre(kHome)) << "foreign owners are not carried to the other engine";
}

TEST_F(TwoEngines, KnowAComponentOnBothAsOne) {
  const auto island = join(both, 1), robot = join(both, 70000);
  ASSERT_TRUE(island->space.set("x", "1"));
  Listener seen;
  const auto handle = robot->space.subscribe(pattern("1:x"), {}, seen.call());
  time.run_ready();
  ASSERT_TRUE(island->space.set("x", "2"));
  time.run_for(100s);
  EXPECT_THAT(island->events, ElementsAre("70000 up"));
  EXPECT_THAT(robot->events, ElementsAre("1 up"));
  EXPECT_THAT(seen.seen, ElementsAre("x=1", "x=2"));
  EXPECT_THAT(log.lines, IsEmpty());
}

TEST_F(TwoEngines, GiveEachStartOneNumberEvenTwoOfOneMicrosecond) {
  const auto island = join(both, 1);
  const auto link = std::move(*both.join(kBot));
  for (int start = 0; start < 3; ++start) {
    auto robot = std::make_unique<TupleSpace>(kBot, time, *link);
    time.run_ready();
    EXPECT_THAT(island->take(), ElementsAre("70000 up"));
    dds.cut(kHome, kBot);
    time.run_ready();
    EXPECT_THAT(island->take(), ElementsAre("70000 lost", "70000 up"));
    dds.mend(kHome, kBot);
    time.run_ready();
    EXPECT_THAT(island->take(), ElementsAre("70000 lost", "70000 up"));
    robot.reset();
    time.run_ready();
    EXPECT_THAT(island->take(), ElementsAre("70000 left"));
  }
  time.run_for(100s);
  EXPECT_THAT(log.lines, IsEmpty());
}

TEST_F(TwoEngines, SeeAComponentLeaveOnce) {
  const auto island = join(both, 1);
  auto robot = join(both, 70000);
  robot.reset();
  time.run_ready();
  EXPECT_THAT(island->take(), ElementsAre("70000 up", "70000 left"));
  EXPECT_THAT(island->space.peers(), IsEmpty());
}

/// A robot on both engines that reads and commands an island on both.
struct MovingComponent : TwoEngines {
  void SetUp() override {
    ASSERT_TRUE(island->space.set("x", "1"));
    ASSERT_TRUE(island->space.set("gone", "1"));
    time.run_ready();
    island->take();
    robot->take();
  }
  void cut(MemoryEcology& engine) {
    engine.cut(kHome, kBot);
    time.run_ready();
  }
  void mend(MemoryEcology& engine) {
    engine.mend(kHome, kBot);
    time.run_ready();
  }
  /// The value that reaches the robot, and the answer to its command.
  void expect_working(const std::string& value) {
    ASSERT_TRUE(island->space.set("x", value));
    time.run_ready();
    EXPECT_EQ(robot->value(1, "x"), value);
    EXPECT_EQ(robot->set(time, 1, "x", value + "!").verdict, Verdict::kApplied);
    EXPECT_EQ(robot->value(1, "x"), value + "!");
    EXPECT_TRUE(wanted);
  }

  std::unique_ptr<Observer> island = join(both, 1), robot = join(both, 70000);
  bool wanted = false;
  Handle demand = island->space.watch_demand(pattern("x"), [this](const Demand& now) { wanted = now.wanted; });
  Handle policy = island->space.add_policy(pattern("x"), [](const RemoteSet&) { return SetDecision::applied(); });
  Listener seen;
  int ends = 0;
  Handle subscription = robot->space.subscribe(pattern("1:**"), {}, seen.call(), [this](OwnerId) { ++ends; });
};

TEST_F(MovingComponent, WorksOnTheSecondEngineWhenTheFirstLosesItAndReturns) {
  expect_working("2");
  EXPECT_EQ(ends, 1);
  seen.take();
  cut(dds);
  EXPECT_THAT(robot->take(), ElementsAre("1 lost", "1 up"));
  EXPECT_THAT(island->take(), ElementsAre("70000 lost", "70000 up"));
  EXPECT_EQ(ends, 2) << "the owner sends a new snapshot";
  EXPECT_THAT(seen.take(), IsEmpty()) << "in which nothing is new";
  expect_working("3");
  mend(dds);
  EXPECT_THAT(robot->take(), ElementsAre("1 lost", "1 up"));
  EXPECT_EQ(ends, 3);
  expect_working("4");
  cut(peis);
  EXPECT_THAT(robot->take(), IsEmpty()) << "it does not live there";
  expect_working("5");
  cut(dds);
  EXPECT_THAT(robot->take(), ElementsAre("1 lost"));
  EXPECT_FALSE(wanted);
  EXPECT_THAT(robot->space.peers(), IsEmpty());
  mend(peis);
  mend(dds);
  EXPECT_THAT(robot->take(), ElementsAre("1 up", "1 lost", "1 up"));
  expect_working("6");
  EXPECT_THAT(log.lines, IsEmpty());
}

TEST_F(MovingComponent, LearnsWhatWasDeletedMeanwhile) {
  time.run_ready();
  EXPECT_EQ(robot->value(1, "gone"), "1");
  dds.cut(kHome, kBot);
  ASSERT_TRUE(island->space.erase("gone"));
  ASSERT_TRUE(island->space.set("x", "9"));
  time.run_ready();
  EXPECT_EQ(robot->value(1, "gone"), "absent");
  EXPECT_EQ(robot->value(1, "x"), "9");
  EXPECT_EQ(island->space.stats().queued, 0U);
}

TEST_F(MovingComponent, SubscribesAndUnsubscribesWhereItLives) {
  cut(dds);
  Listener more;
  auto handle = robot->space.subscribe(pattern("1:y"), {}, more.call());
  ASSERT_TRUE(island->space.set("y", "1"));
  time.run_ready();
  mend(dds);
  ASSERT_TRUE(island->space.set("y", "2"));
  time.run_ready();
  EXPECT_THAT(more.take(), ElementsAre("y=1", "y=2"));
  handle.reset();
  subscription.reset();
  time.run_ready();
  EXPECT_FALSE(wanted);
  cut(dds);
  EXPECT_FALSE(wanted) << "the subscription ended on both engines";
  EXPECT_FALSE(island->space.has_subscriber(*island->space.find("y")));
}

TEST_F(MovingComponent, KeepsItsSummary) {
  ASSERT_TRUE(robot->space.describe("{\"name\":\"bot\"}"));
  std::vector<std::string> summaries;
  const auto watch = island->space.watch_summaries(
      [&](OwnerId, std::string_view summary) { summaries.push_back(std::string(summary)); });
  time.run_ready();
  EXPECT_THAT(summaries, SizeIs(1));
  cut(dds);
  EXPECT_EQ(island->space.summary(kBot), "{\"name\":\"bot\"}");
  ASSERT_TRUE(robot->space.describe("{}"));
  time.run_ready();
  EXPECT_EQ(island->space.summary(kBot), "{}");
  mend(dds);
  EXPECT_EQ(island->space.summary(kBot), "{}");
}

TEST_F(TwoEngines, MoveAComponentThatTheSecondEngineMetFirst) {
  dds.cut(kHome, kBot);
  const auto island = join(both, 1), robot = join(both, 70000);
  EXPECT_THAT(island->take(), ElementsAre("70000 up"));
  dds.mend(kHome, kBot);
  time.run_ready();
  EXPECT_THAT(island->take(), ElementsAre("70000 lost", "70000 up"));
}

TEST_F(TwoEngines, KeepTheFirstOfTwoComponentsWithOneIdAndLogThemOnce) {
  const auto island = join(both, 1);
  auto first = join(peis, 7);
  const auto second = join(dds, 7);
  ASSERT_TRUE(first->space.set("x", "first"));
  ASSERT_TRUE(second->space.set("x", "second"));
  ASSERT_TRUE(island->space.set("lamp", "off"));
  const auto policy =
      island->space.add_policy(pattern("lamp"), [](const RemoteSet&) { return SetDecision::applied(); });
  const auto handle = island->space.subscribe(pattern("*:x"), {}, [](const Event&) {});
  time.run_for(4s);
  EXPECT_THAT(log.lines, IsEmpty()) << "the first contact may settle it";
  time.run_for(2s);
  EXPECT_THAT(log.lines,
              ElementsAre("tuples: two components have id 7: one on dds on host here and one on peis on host "
                          "there. The one on dds is ignored: give one of them another id"));
  EXPECT_EQ(island->value(7, "x"), "first");
  EXPECT_EQ(first->set(time, 1, "lamp", "on").verdict, Verdict::kApplied);
  const auto refused = second->set(time, 1, "lamp", "dim");
  EXPECT_EQ(refused.verdict, Verdict::kRefused);
  EXPECT_EQ(refused.text, "setting 'lamp': another component with id 7 is present");
  EXPECT_EQ(island->value(1, "lamp"), "on");
  for (int repeat = 0; repeat < 3; ++repeat) {
    dds.cut(kHome, OwnerId(7));
    time.run_for(100s);
    dds.mend(kHome, OwnerId(7));
    time.run_for(100s);
  }
  EXPECT_THAT(log.lines, SizeIs(1));
  EXPECT_THAT(island->take(), ElementsAre("7 up"));
  first.reset();
  time.run_ready();
  EXPECT_THAT(island->take(), ElementsAre("7 left", "7 up"));
  EXPECT_EQ(island->value(7, "x"), "second");
}

TEST_F(TwoEngines, RefuseAnIdThatOneOfThemHasAlready) {
  const auto kernel = join(peis, 7);
  const auto link = both.join(OwnerId(7));
  ASSERT_FALSE(link);
  EXPECT_EQ(link.error().code, ErrorCode::kDuplicate);
  EXPECT_THAT(link.error().text, HasSubstr("peis: component 7"));
  EXPECT_TRUE(dds.join(OwnerId(7))) << "nothing stays behind on the engine that accepted it";
}

TEST_F(TwoEngines, MayBeThree) {
  MemoryEcology third(time);
  JoinedEcology all{{{"dds", dds}, {"peis", peis}, {"third", third}}, time, log};
  const auto island = join(all, 1), robot = join(all, 70000);
  Listener seen;
  const auto handle = robot->space.subscribe(pattern("1:x"), {}, seen.call());
  int value = 0;
  for (auto* engine : {&dds, &peis}) {
    ASSERT_TRUE(island->space.set("x", std::to_string(++value)));
    time.run_ready();
    engine->cut(kHome, kBot);
    time.run_ready();
  }
  ASSERT_TRUE(island->space.set("x", "3"));
  time.run_ready();
  EXPECT_THAT(seen.seen, ElementsAre("x=1", "x=2", "x=3"));
  dds.mend(kHome, kBot);
  time.run_ready();
  EXPECT_THAT(robot->take(), ElementsAre("1 up", "1 lost", "1 up", "1 lost", "1 up", "1 lost", "1 up"));
  EXPECT_THAT(log.lines, IsEmpty());
}

}  // namespace
}  // namespace rubicon::tuples::joined
