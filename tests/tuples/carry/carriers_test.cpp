#include "tuples/carry/carrying.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::carry {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

TEST_F(Carrying, PatternsLimitWhatPasses) {
  const auto island = carry({"kitchen.**", "*.name"});
  const auto home = join<Home>(dds, 7);
  ASSERT_TRUE(home->space.set("hall.name", "Hall"));
  const auto reader = join(peis, 8);
  settle();
  Listener all, narrow, other;
  int ends = 0;
  const auto one = reader->space.subscribe(pattern("7:**"), {}, all.call(), [&](OwnerId) { ++ends; });
  const auto two = reader->space.subscribe(pattern("*:*.lamp"), {}, narrow.call());
  const auto three = reader->space.subscribe(pattern("7:hall.lamp"), {}, other.call(), [&](OwnerId) { ++ends; });
  settle();
  EXPECT_THAT(all.take(), testing::UnorderedElementsAre("kitchen.lamp=off", "kitchen.log=a", "hall.name=Hall"));
  EXPECT_THAT(narrow.take(), ElementsAre("kitchen.lamp=off"));
  EXPECT_THAT(other.take(), IsEmpty());
  EXPECT_EQ(ends, 2) << "one snapshot each, also of two patterns or none";
  const auto answer = reader->set(time, 7, "hall.lamp", "on");
  EXPECT_EQ(answer.verdict, Verdict::kRefused);
  EXPECT_THAT(answer.text, HasSubstr("component 1 does not carry it from dds to peis"));
  EXPECT_EQ(reader->set(time, 7, "kitchen.lamp", "on").verdict, Verdict::kApplied);
}

TEST_F(Carrying, ComponentsOnBothEnginesSeeTheOriginOnce) {
  joined::JoinedEcology both({{"peis", peis}, {"dds", dds}}, time, log);
  const auto island = carry({"7"});
  const auto robot = join(both, 70'000);
  Listener seen;
  const auto handle = robot->space.subscribe(pattern("*:hall.lamp"), {}, seen.call());
  auto home = join<Home>(dds, 7);
  settle();
  time.run_for(70s);
  EXPECT_EQ(island->carrier.stand_ins(), 1U);
  EXPECT_THAT(robot->take(), ElementsAre("1 up", "7 up")) << "whatever the order of the engines";
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=off"));
  EXPECT_EQ(robot->set(time, 7, "hall.lamp", "on").verdict, Verdict::kApplied);
  EXPECT_EQ(home->sets.back().from, OwnerId(70'000));
  home.reset();
  time.run_ready();
  EXPECT_THAT(robot->take(), ElementsAre("7 left"));
  for (const auto& line : log.lines) EXPECT_THAT(line, Not(HasSubstr("two components"))) << line;
}

TEST_F(Carrying, AComponentThatLostTheOriginUsesTheStandInUntilItIsBack) {
  joined::JoinedEcology both({{"dds", dds}, {"peis", peis}}, time, log);
  const auto robot = join(both, 70'000);
  const auto island = carry({"7"});
  const auto home = join<Home>(dds, 7);
  settle();
  robot->take();
  dds.memory.cut(OwnerId(7), OwnerId(70'000));
  time.run_ready();
  EXPECT_THAT(robot->take(), ElementsAre("7 lost", "7 up"));
  dds.memory.mend(OwnerId(7), OwnerId(70'000));
  time.run_ready();
  EXPECT_THAT(robot->take(), ElementsAre("7 lost", "7 up"));
}

TEST_F(Carrying, OfTwoCarriersTheOneWithTheLowestIdCarries) {
  const auto one = carry({"**"}, 1), two = carry({"**"}, 2);
  const auto home = join<Home>(dds, 7);
  const auto reader = join(peis, 8);
  Listener seen;
  const auto handle = reader->space.subscribe(pattern("*:hall.lamp"), {}, seen.call());
  time.run_for(60s);
  EXPECT_EQ(one->carrier.stand_ins() + two->carrier.stand_ins(), 2U) << "of 7 and of 8";
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=off"));
  EXPECT_THAT(home->space.peers(), SizeIs(3)) << "1, 2 and 8: no A-B-A";
  EXPECT_THAT(reader->space.peers(), SizeIs(3));
  EXPECT_EQ(one->carrier.stand_ins(), 2U) << "the one with the lowest id";
  EXPECT_THAT(log.lines, Contains(HasSubstr("component 1 carries the same between dds and peis: it does")));
  EXPECT_THAT(log.lines, Not(Contains(HasSubstr("with other rules"))));
  ASSERT_TRUE(home->space.set("hall.lamp", "on"));
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=on"));
}

TEST_F(Carrying, OfTwoCarriersWithOtherRulesTheFirstOneCarriesAndTheOtherWarns) {
  const auto home = join<Home>(dds, 7);
  const auto one = carry({"**"}, 2);
  settle();
  const auto two = carry({"7"}, 1);
  const auto reader = join(peis, 8);
  time.run_for(60s);
  EXPECT_EQ(two->carrier.stand_ins(), 0U);
  EXPECT_THAT(reader->space.peers(), Contains(OwnerId(7)));
  EXPECT_THAT(log.lines, Contains(HasSubstr("component 2 carries component 7 to peis too, with other rules")));
}

TEST_F(Carrying, TheLowestTakesOverAlsoFromOneThatCarries) {
  const auto two = carry({"7"}, 2);
  const auto home = join<Home>(dds, 7);
  const auto reader = join(peis, 8);
  Listener seen;
  const auto handle = reader->space.subscribe(pattern("7:hall.lamp"), {}, seen.call());
  settle();
  settle();
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=off"));
  auto one = carry({"7"}, 1);
  settle();
  settle();
  EXPECT_EQ(one->carrier.stand_ins(), 2U);
  EXPECT_EQ(two->carrier.stand_ins(), 0U) << "also none of the reader, which the other one needs";
  ASSERT_TRUE(home->space.set("hall.lamp", "on"));
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=on")) << "the copy stayed";
}

TEST_F(Carrying, AnotherCarrierTakesOverWhenTheFirstOneEnds) {
  auto one = carry({"7"}, 1);
  const auto two = carry({"7"}, 2);
  const auto home = join<Home>(dds, 7);
  const auto reader = join(peis, 8);
  settle();
  ASSERT_EQ(one->carrier.stand_ins(), 1U);
  one.reset();
  time.run_for(Carrier::kSettle - 1ms);
  EXPECT_EQ(two->carrier.stand_ins(), 0U);
  time.run_for(2ms);
  EXPECT_EQ(two->carrier.stand_ins(), 1U) << "as soon as all engines had time to meet others";
  time.run_ready();
  EXPECT_THAT(reader->space.peers(), ElementsAre(OwnerId(2), OwnerId(7)));
}

TEST_F(Carrying, AChainOfThreeEnginesCarriesOverOneStepOnly) {
  TestEngine third(time, "far");
  const auto home = join<Home>(dds, 7);
  const auto near = carry({"**"}, 1);
  time.run_for(1s);
  const auto far = std::make_unique<CarryingIsland>(peis, third, time, log, 2, std::vector<std::string>{"**"});
  const auto middle = join(peis, 8), end = join(third, 9);
  time.run_for(60s);
  EXPECT_THAT(middle->space.peers(), ElementsAre(OwnerId(1), OwnerId(2), OwnerId(7), OwnerId(9)));
  EXPECT_THAT(end->space.peers(), Not(Contains(OwnerId(7)))) << "a stand-in is not carried on";
  EXPECT_THAT(home->space.peers(), Not(Contains(OwnerId(9))));
  Listener seen;
  const auto handle = end->space.subscribe(pattern("*:hall.lamp"), {}, seen.call());
  settle();
  EXPECT_THAT(seen.take(), IsEmpty());
}

TEST_F(Carrying, StandInsAreBoundedAndTheBoundIsNamedOnce) {
  const auto island = carry({"**"}, 1, 3);
  std::vector<std::unique_ptr<Observer>> many;
  for (std::uint32_t id = 100; id < 105; ++id) many.push_back(join(dds, id));
  time.run_for(30s);
  EXPECT_EQ(island->carrier.stand_ins(), 3U);
  const auto named = [&] {
    return std::count_if(log.lines.begin(), log.lines.end(), [](const std::string& line) {
      return line.find("there are 3 stand-ins, which is the most") != line.npos;
    });
  };
  EXPECT_EQ(named(), 1);
  many.erase(many.begin());
  settle();
  EXPECT_EQ(island->carrier.stand_ins(), 3U) << "the next one has its place";
  EXPECT_EQ(named(), 1);
}

TEST_F(Carrying, ThoseThatWereRefusedAndLeftDelayNobodyWhenAPlaceIsFree) {
  const auto island = carry({"**"}, 1, 1);
  auto first = join(dds, 100);
  settle();
  std::vector<std::unique_ptr<Observer>> many;
  for (std::uint32_t id = 200; id < 400; ++id) many.push_back(join(dds, id));
  settle();
  many.clear();
  time.run_ready();
  const auto last = join(dds, 500);
  settle();
  first.reset();
  time.run_for(50ms);
  EXPECT_EQ(island->carrier.stand_ins(), 1U) << "200 others would take 125 ms";
}

TEST_F(Carrying, OneThatIsDisplacedEndsAndComesBackLater) {
  const auto island = carry({"7"});
  const auto home = join<Home>(dds, 7);
  settle();
  ASSERT_EQ(island->carrier.stand_ins(), 1U);
  peis.displaced.at(OwnerId(7))();
  EXPECT_EQ(island->carrier.stand_ins(), 0U);
  EXPECT_THAT(log.lines, Contains(HasSubstr("component 7 is met on peis by another way too")));
  time.run_for(30s);
  EXPECT_EQ(island->carrier.stand_ins(), 1U) << "no other component has this id";
}

TEST_F(Carrying, ARestartOfTheReaderLeavesNothingBehind) {
  const auto island = carry({"7"});
  const auto home = join<Home>(dds, 7);
  for (int start = 0; start < 3; ++start) {
    const auto reader = join(peis, 8);
    settle();
    for (int set = 0; set < 2; ++set) EXPECT_EQ(reader->set(time, 7, "hall.lamp", "on").verdict, Verdict::kApplied);
  }
  EXPECT_EQ(home->sets.size(), 6U);
  time.run_for(30s);
  EXPECT_THAT(home->space.peers(), ElementsAre(OwnerId(1)));
}

TEST_F(Carrying, AStandInThatOnlyCommandedEndsSomeTimeAfterItsLastUse) {
  const auto island = carry({"7"});
  const auto home = join<Home>(dds, 7);
  const auto reader = join(peis, 8);
  settle();
  for (int set = 0; set < 3; ++set) {
    EXPECT_EQ(reader->set(time, 7, "hall.lamp", "on").verdict, Verdict::kApplied);
    time.run_for(Carrier::kLinger - 1s);
    EXPECT_EQ(island->carrier.stand_ins(), 2U);
  }
  time.run_for(2s);
  EXPECT_EQ(island->carrier.stand_ins(), 1U);
}

TEST_F(Carrying, AStandInHasTheRightsOfTheHostOfItsComponent) {
  DeclaredHostPolicy policy(OwnerId(7), "here", false, Log(log, "tuples"));
  RemoteSet set;
  set.from = OwnerId(8);
  policy.peer_up({OwnerId(8), 1, marked_host("here", OwnerId(1))});
  EXPECT_TRUE(policy.may_set(set));
  policy.peer_up({OwnerId(8), 1, marked_host("there", OwnerId(1))});
  EXPECT_EQ(policy.may_set(set).error().code, ErrorCode::kRefused) << "also if the carrier is here";
}

TEST_F(Carrying, HostsOfStandInsHaveAMark) {
  EXPECT_EQ(marked_host("abc", OwnerId(65'532)), "abc~65532");
  EXPECT_EQ(marked_host(std::string(80, 'h'), OwnerId(1)).size(), 64U);
  EXPECT_EQ(carrier_of("abc~12"), OwnerId(12));
  EXPECT_EQ(real_host("abc~12"), "abc");
  for (const auto* host : {"abc", "abc~", "abc~x", "", "~0"}) {
    EXPECT_EQ(carrier_of(host), model::kNoOwner) << host;
    EXPECT_EQ(real_host(host), host);
  }
}

}  // namespace
}  // namespace rubicon::tuples::carry
