#include "tuples/carry/carrying.h"

namespace rubicon::tuples::carry {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A home (7) on one engine, a reader (8) on the other one; the island between carries the home.
struct OneHome : Carrying, testing::WithParamInterface<bool> {
  void SetUp() override {
    Carrying::SetUp();
    settle();
    seen.take();
  }
  TestEngine& origin = dds;
  std::unique_ptr<CarryingIsland> island = carry({"7"});
  std::unique_ptr<Home> home = join<Home>(dds, 7);
  std::unique_ptr<Observer> reader = join(peis, 8);
  Listener seen;
};

TEST_F(OneHome, HasAStandInOnTheOtherEngineOnly) {
  EXPECT_THAT(reader->space.peers(), ElementsAre(OwnerId(1), OwnerId(7)));
  EXPECT_THAT(home->space.peers(), ElementsAre(OwnerId(1))) << "the reader is not carried";
  EXPECT_THAT(island->self.take(), Not(Contains("7 lost"))) << "the carrier does not see its own stand-ins";
  EXPECT_EQ(island->carrier.stand_ins(), 1U);
}

TEST_F(OneHome, PassesValuesWithAllThatBelongsToThem) {
  SetOptions options{"text/x-light", WallTime(5s), 60s};
  ASSERT_TRUE(home->space.set("kitchen.lamp", "dim", options));
  const auto handle = reader->space.subscribe(pattern("7:kitchen.lamp"), {}, seen.call());
  settle();
  ASSERT_TRUE(home->space.set("kitchen.lamp", "on", options));
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("kitchen.lamp=dim", "kitchen.lamp=on"));
  const auto copy = *reader->space.get(OwnerId(7), "kitchen.lamp"), own = *home->space.get(OwnerId(7), "kitchen.lamp");
  EXPECT_EQ(copy.sequence, 3U);
  EXPECT_EQ(copy.creator, own.creator);
  EXPECT_EQ(copy.media_type, "text/x-light");
  EXPECT_EQ(copy.user_time, WallTime(5s));
  EXPECT_EQ(copy.write_time, own.write_time);
  EXPECT_EQ(copy.expire_time, own.expire_time);
  ASSERT_TRUE(home->space.erase("kitchen.lamp"));
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("kitchen.lamp deleted"));
  ASSERT_TRUE(home->space.set("kitchen.lamp", "brief", {.lifetime = 2s}));
  time.run_for(3s);
  EXPECT_THAT(seen.take(), ElementsAre("kitchen.lamp=brief", "kitchen.lamp expired"));
}

TEST_F(OneHome, IsReadByPatternsOfAnyOwnerAndEndsTheirSnapshots) {
  std::vector<OwnerId> ends;
  const auto handle =
      reader->space.subscribe(pattern("*:*.lamp"), {}, seen.call(), [&](OwnerId owner) { ends.push_back(owner); });
  settle();
  EXPECT_THAT(seen.take(), testing::UnorderedElementsAre("kitchen.lamp=off", "hall.lamp=off"));
  EXPECT_THAT(ends, testing::UnorderedElementsAre(OwnerId(1), OwnerId(7)));
}

TEST_F(OneHome, IsMeasuredAtTheFastestIntervalThatSomebodyWants) {
  const auto slow = reader->space.subscribe(pattern("7:kitchen.*"), {.minimum = 10s}, seen.call());
  settle();
  EXPECT_TRUE(home->demand.wanted);
  EXPECT_EQ(home->demand.interval, 10s);
  auto fast = std::make_optional(reader->space.subscribe(pattern("7:kitchen.lamp"), {.minimum = 500ms}, seen.call()));
  time.run_ready();
  EXPECT_EQ(home->demand.interval, 500ms);
  fast.reset();
  time.run_ready();
  EXPECT_EQ(home->demand.interval, 10s);
  reader.reset();
  time.run_ready();
  EXPECT_FALSE(home->demand.wanted) << "the reader left";
  time.run_for(20s);
  EXPECT_THAT(home->space.peers(), ElementsAre(OwnerId(1))) << "its stand-in too";
}

TEST_F(OneHome, PassiveReadersCreateNoDemand) {
  const auto handle = reader->space.subscribe(pattern("7:**"), {.passive = true}, seen.call());
  settle();
  EXPECT_EQ(seen.seen.size(), 3U);
  EXPECT_FALSE(home->demand.wanted);
}

TEST_F(OneHome, DecidesAboutRemoteSetsOfTheRealComponent) {
  Reply answer;
  const auto set = [&](std::string_view value, const SetOptions& options = {}) {
    answer = {{}, 0, Verdict::kExpired, {}, "none", 0};
    reader->space.set_remote(
        OwnerId(7), "kitchen.lamp", value, 10s, [&](const Reply& reply) { answer = reply; }, options);
    time.run_for(4s);
    return answer.verdict;
  };
  EXPECT_EQ(set("on"), Verdict::kApplied) << answer.text;
  EXPECT_EQ(answer.sequence, 2U);
  EXPECT_EQ(home->sets.back().from, OwnerId(8));
  EXPECT_EQ(home->sets.back().request, 1U) << "the owner shows the outcome with the number that the reader knows";
  EXPECT_TRUE(home->sets.back().time_to_live_given);
  EXPECT_EQ(home->space.get(OwnerId(7), "kitchen.lamp")->creator, OwnerId(8));
  EXPECT_EQ(set("bad"), Verdict::kRefused);
  EXPECT_EQ(answer.text, "no such word");
  EXPECT_EQ(set("off", {.expected_sequence = 7}), Verdict::kRefused);
  EXPECT_EQ(answer.sequence, 2U);
  reader->space.append_remote(OwnerId(7), "kitchen.log", "b", 5s, [&](const Reply& reply) { answer = reply; });
  time.run_for(1s);
  EXPECT_EQ(answer.verdict, Verdict::kApplied) << answer.text;
  EXPECT_EQ(home->space.get(OwnerId(7), "kitchen.log")->value, "ab");
}

TEST_F(OneHome, KeepsTheOrderOfRemoteSetsThatWaitForTheStandInOfTheirSender) {
  const auto fresh = join(peis, 10);
  for (const auto* value : {"1", "2", "3"}) fresh->space.set_remote(OwnerId(7), "hall.lamp", value, 10s, {});
  settle();
  ASSERT_EQ(home->sets.size(), 3U);
  EXPECT_EQ(home->sets[0].value + home->sets[1].value + home->sets[2].value, "123");
  EXPECT_EQ(home->sets[0].time_to_live, 10s - Carrier::kSettle) << "the wait counts";
}

TEST_F(OneHome, AsksThePoliciesOfBothEngines) {
  peis.refused.insert(OwnerId(8));
  settle();
  auto answer = reader->set(time, 7, "hall.lamp", "on");
  EXPECT_EQ(answer.verdict, Verdict::kRefused);
  EXPECT_EQ(answer.text, "not from this host");
  ASSERT_EQ(peis.answers.size(), 1U) << "for the audit";
  EXPECT_EQ(peis.answers[0].text, answer.text);
  peis.refused.clear();
  dds.refused.insert(OwnerId(8));
  reader->space.set_remote(OwnerId(7), "hall.lamp", "on", 10s, [&](const Reply& reply) { answer = reply; });
  settle();
  EXPECT_EQ(answer.verdict, Verdict::kRefused);
  EXPECT_THAT(home->sets, IsEmpty());
}

TEST_F(OneHome, PassesWhatTheRightsOfTheCarrierLetTheReaderSee) {
  peis.limits = {{"hall.lamp", {.read = false}}, {"kitchen.log", {.demand = false}}};
  const auto handle = reader->space.subscribe(pattern("7:**"), {.minimum = 1s}, seen.call());
  settle();
  EXPECT_THAT(seen.take(), testing::UnorderedElementsAre("kitchen.lamp=off", "kitchen.log=a"));
  ASSERT_TRUE(home->space.set("hall.lamp", "on"));
  time.run_ready();
  EXPECT_THAT(seen.take(), IsEmpty());
}

TEST_F(OneHome, WakesWhatTheRightsOfTheCarrierLetTheReaderWake) {
  Demand log, hall;
  const auto of_log = home->space.watch_demand(pattern("kitchen.log"), [&](const Demand& now) { log = now; });
  const auto of_hall = home->space.watch_demand(pattern("hall.lamp"), [&](const Demand& now) { hall = now; });
  peis.limits = {{"kitchen.log", {.demand = false}}, {"kitchen.lamp", {.interval = 30s}}};
  auto handle = std::make_optional(reader->space.subscribe(pattern("7:**"), {.minimum = 1s}, seen.call()));
  settle();
  EXPECT_EQ(home->demand.interval, 30s);
  EXPECT_EQ(hall.interval, 1s);
  EXPECT_FALSE(log.wanted);
  ASSERT_TRUE(home->space.erase("hall.lamp"));
  time.run_ready();
  ASSERT_TRUE(home->space.set("hall.lamp", "on"));
  time.run_for(1s);
  EXPECT_TRUE(hall.wanted) << "again";
  const auto lamp = reader->space.subscribe(pattern("7:kitchen.lamp"), {.minimum = 60s}, seen.call());
  handle.reset();
  time.run_ready();
  EXPECT_FALSE(hall.wanted);
  EXPECT_EQ(home->demand.interval, 60s) << "by its key";
}

TEST_F(OneHome, ShowsItsSummary) {
  ASSERT_TRUE(home->space.describe("{\"name\": \"home\"}"));
  time.run_ready();
  EXPECT_EQ(reader->space.summary(OwnerId(7)), "{\"name\": \"home\"}");
}

TEST_F(OneHome, LeavesWithItsOriginAndComesAgainWithIt) {
  const auto handle = reader->space.subscribe(pattern("7:hall.lamp"), {}, seen.call());
  settle();
  reader->take();
  home.reset();
  time.run_ready();
  EXPECT_THAT(reader->take(), ElementsAre("7 left"));
  EXPECT_EQ(island->carrier.stand_ins(), 1U) << "the stand-in of the reader, for a while";
  home = join<Home>(dds, 7);
  ASSERT_TRUE(home->space.set("hall.lamp", "again"));
  settle();
  EXPECT_THAT(reader->take(), ElementsAre("7 up"));
  EXPECT_EQ(seen.take().back(), "hall.lamp=again");
}

TEST_F(OneHome, IsNotCarriedOnceItIsOnBothEngines) {
  home.reset();
  joined::JoinedEcology both({{"dds", dds}, {"peis", peis}}, time, log);
  home = join<Home>(both, 7);
  reader->take();
  settle();
  EXPECT_EQ(island->carrier.stand_ins(), 0U);
  const auto handle = reader->space.subscribe(pattern("7:hall.lamp"), {}, seen.call());
  time.run_ready();
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=off"));
  EXPECT_THAT(reader->take(), IsEmpty());
}

TEST_F(OneHome, EndsWithTheCarrier) {
  const auto handle = reader->space.subscribe(pattern("7:kitchen.lamp"), {}, seen.call());
  settle();
  ASSERT_TRUE(home->demand.wanted);
  reader->take();
  island.reset();
  time.run_ready();
  EXPECT_THAT(reader->take(), testing::UnorderedElementsAre("1 left", "7 left"));
  EXPECT_FALSE(home->demand.wanted);
  EXPECT_EQ(reader->value(7, "kitchen.lamp"), "off") << "the copy stays for a while";
  time.run_for(kOwnerGrace + 1s);
  EXPECT_EQ(seen.take().back(), "kitchen.lamp lost");
}

TEST_F(OneHome, GivesAStalledReaderTheLatestValues) {
  const auto handle = reader->space.subscribe(pattern("7:hall.lamp"), {}, seen.call());
  settle();
  seen.take();
  peis.stalled.insert(OwnerId(8));
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(home->space.set("hall.lamp", std::to_string(i)));
    time.run_ready();
  }
  peis.stalled.clear();
  time.run_for(1s);
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=99"));
}

TEST_F(OneHome, AsksAgainWhenTooMuchWaitedForAStalledReader) {
  const auto handle = reader->space.subscribe(pattern("7:**"), {}, seen.call());
  settle();
  ASSERT_TRUE(home->space.set("short", "1"));
  time.run_ready();
  peis.stalled.insert(OwnerId(8));
  const std::string large(1'000'000, 'x');
  ASSERT_TRUE(home->space.erase("short"));
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(home->space.set("large." + std::to_string(i), large));
    time.run_ready();
  }
  peis.stalled.clear();
  time.run_for(1s);
  EXPECT_EQ(reader->value(7, "large.39").size(), large.size());
  EXPECT_EQ(reader->value(7, "large.0").size(), large.size());
  EXPECT_EQ(reader->value(7, "short"), "absent") << "its deletion was dropped, the snapshot is without it";
}

TEST_F(OneHome, ReadsTheOtherWayToo) {
  const auto kernel = join<Home>(peis, 9);
  const auto other = join(dds, 70'000);
  island.reset();
  island = carry({"7", "9"});
  settle();
  const auto handle = other->space.subscribe(pattern("9:hall.lamp"), {}, seen.call());
  settle();
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=off"));
  EXPECT_EQ(other->set(time, 9, "hall.lamp", "on").verdict, Verdict::kApplied);
  EXPECT_EQ(kernel->set(time, 7, "hall.lamp", "x").verdict, Verdict::kApplied) << "both are carried";
  EXPECT_THAT(seen.take(), ElementsAre("hall.lamp=on"));
}

}  // namespace
}  // namespace rubicon::tuples::carry
