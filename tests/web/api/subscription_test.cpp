#include "web/api/feed.h"
#include "web/api/forms.h"
#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using Subscriptions = Sites;

TEST_F(Subscriptions, ASubscriptionDeliversWhatIsThereThenTheEndOfTheSnapshotThenChanges) {
  start_lamp();
  measure(20.5);
  auto& page = Sites::page();
  const auto id = page.ask({{"do", "subscribe"}, {"pattern", "1:proxy.*.*.sensor.temperature-1.value"}});
  scheduler.run_for(100ms);
  ASSERT_EQ(page.frames.size(), 2U);
  EXPECT_EQ(page.frames[0], Json({{"id", id}, {"ok", true}, {"subscription", 1}}));
  const auto& first = page.frames[1];
  EXPECT_EQ(first["s"], 1);
  EXPECT_EQ(first["k"], Json({{"0", kTemperature}}));
  EXPECT_EQ(first["set"][0][0], 0);
  EXPECT_EQ(first["set"][0][1], "20.5");
  EXPECT_EQ(first["snapshot"], 1);
  page.take_frames();
  measure(21);
  scheduler.run_for(100ms);
  ASSERT_EQ(page.frames.size(), 1U);
  EXPECT_FALSE(page.frames[0].contains("k")) << "the number stands for the key";
  EXPECT_EQ(page.frames[0]["set"][0][1], "21");
  EXPECT_EQ(page.frames[0]["set"][0].size(), 4U);
}

TEST_F(Subscriptions, TheTimeIsThatOfTheMeasurementElseThatOfTheWrite) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("a", "1", {.user_time = WallTime(1500ms)}));
  ASSERT_TRUE(owner.set("b", "2"));
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:*"}});
  scheduler.run_for(100ms);
  const auto sets = page.sets();
  ASSERT_EQ(sets.size(), 2U);
  EXPECT_EQ(sets.at("70000:a")[3], 1.5);
  EXPECT_NEAR(sets.at("70000:b")[3].get<double>(), base::to_seconds(scheduler.wall_now()), 1);
}

TEST_F(Subscriptions, ManyChangesWithinTheMinimumIntervalBecomeOne) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("a", "0"));
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:a"}, {"min", 200}});
  scheduler.run_for(1s);
  page.take_frames();
  for (int i = 1; i <= 100; ++i) {
    ASSERT_TRUE(owner.set("a", std::to_string(i)));
    scheduler.run_for(10ms);
  }
  scheduler.run_for(1s);
  EXPECT_THAT(page.frames.size(), testing::AllOf(testing::Ge(5U), testing::Le(6U)));
  EXPECT_EQ(page.frames.back()["set"][0][1], "100") << "the latest value always arrives";
}

TEST_F(Subscriptions, EachPressOfAButtonArrivesInOrder) {
  auto& island = start_island(1);
  (void)island;
  model::Join join;
  join.capabilities.push_back(capability(sensor("button")));
  devices_of(1).say("7", join);
  scheduler.run_for(1s);
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "1:proxy.*.*.sensor.*.value"}, {"min", 500}});
  scheduler.run_for(1s);
  page.take_frames();
  const auto* type = types.find("button");
  ASSERT_EQ(type->report, model::Report::kEvent);
  for (const auto* press : {"1", "2", "3"}) {
    devices_of(1).say("7", reading(sensor("button"), TypeCatalogue::parse(*type, press).value()));
    scheduler.run_for(10ms);
  }
  scheduler.run_for(5s);
  std::vector<std::uint64_t> sequences;
  for (const auto& frame : page.frames) {
    for (const auto& set : frame["set"]) sequences.push_back(set[2]);
  }
  ASSERT_EQ(sequences.size(), 3U) << "that the event is over is none";
  EXPECT_EQ(sequences[2], sequences[0] + 2);
  page.take_frames();
  page.ask({{"do", "subscribe"}, {"pattern", "1:proxy.*.*.sensor.button-1.value"}});
  scheduler.run_for(1s);
  std::vector<std::string> late;
  for (const auto& frame : page.frames) {
    for (const auto& set : frame.value("set", Json::array())) late.push_back(set[1]);
  }
  EXPECT_EQ(late, std::vector<std::string>{""}) << "who comes later finds no event";
}

TEST_F(Subscriptions, EventsBeyondTheStockAreCountedAsLostAndTheNewestArrive) {
  auto& owner = component(70000);
  const std::string key = "proxy.a.b.sensor.button-1.value";
  ASSERT_TRUE(owner.set(key, "first"));
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:**"}});
  scheduler.run_for(1s);
  page.take_frames();
  page.read(false);
  for (int i = 1; i <= 1500; ++i) {
    ASSERT_TRUE(owner.set(key, std::to_string(i)));
    scheduler.run_ready();
  }
  page.read(true);
  scheduler.run_for(1s);
  std::size_t lost = 0;
  std::vector<std::string> values;
  for (const auto& frame : page.frames) {
    if (frame.contains("lost")) lost += frame["lost"]["events"].get<std::size_t>();
    if (!frame.contains("set")) continue;
    for (const auto& set : frame["set"]) values.push_back(set[1]);
  }
  EXPECT_EQ(values.size(), 1000U);
  EXPECT_EQ(lost, 500U);
  EXPECT_EQ(values.front(), "501");
  EXPECT_EQ(values.back(), "1500");
}

TEST_F(Subscriptions, AReaderThatTakesNothingCostsOneValueForEachTupleAndIsToldSo) {
  auto& owner = component(70000);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(owner.set("t" + std::to_string(i), "0"));
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:*"}});
  scheduler.run_for(1s);
  page.take_frames();
  page.read(false);
  for (int round = 1; round <= 100; ++round) {
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(owner.set("t" + std::to_string(i), std::to_string(round)));
    scheduler.run_for(50ms);
  }
  page.read(true);
  scheduler.run_for(100ms);
  std::size_t sets = 0;
  bool slow = false;
  for (const auto& frame : page.frames) {
    slow = slow || frame.contains("slow");
    if (!frame.contains("set")) continue;
    for (const auto& set : frame["set"]) {
      ++sets;
      EXPECT_EQ(set[1], "100");
    }
  }
  EXPECT_EQ(sets, 10U);
  EXPECT_FALSE(slow) << "no frame was under way, so nothing waited for the reader";
}

TEST_F(Subscriptions, SnapshotsComeInSlices) {
  auto& owner = component(70000);
  const std::string value(1000, 'x');
  for (int i = 0; i < 300; ++i) ASSERT_TRUE(owner.set("t" + std::to_string(i), value));
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:*"}});
  scheduler.run_for(1s);
  EXPECT_GT(page.texts.size(), 4U);
  std::size_t sets = 0;
  for (std::size_t i = 1; i < page.texts.size(); ++i) {
    EXPECT_LE(page.texts[i].size(), Feed::kMaxFrame + 2048);
    sets += page.frames[i]["set"].size();
    EXPECT_EQ(page.frames[i].contains("snapshot"), i + 1 == page.texts.size());
  }
  EXPECT_EQ(sets, 300U);
}

TEST_F(Subscriptions, ATupleThatIsGoneFreesItsNumber) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("a", "1"));
  ASSERT_TRUE(owner.set("b", "1", {.lifetime = 5s}));
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:*"}});
  scheduler.run_for(1s);
  page.take_frames();
  ASSERT_TRUE(owner.erase("a"));
  scheduler.run_for(10s);
  std::vector<Json> gone;
  for (const auto& frame : page.frames) {
    if (!frame.contains("gone")) continue;
    for (const auto& one : frame["gone"]) gone.push_back(one);
  }
  ASSERT_EQ(gone.size(), 2U);
  EXPECT_EQ(gone[0][1], "deleted");
  EXPECT_EQ(gone[1][1], "expired");
  EXPECT_NE(gone[0][0], gone[1][0]);
  page.take_frames();
  ASSERT_TRUE(owner.set("c", "1"));
  scheduler.run_for(1s);
  EXPECT_EQ(page.frames.at(0)["k"].size(), 1U);
  EXPECT_EQ(page.frames.at(0)["k"].begin().value(), "70000:c");
}

TEST_F(Subscriptions, ATupleThatCameAndWentBetweenTwoFramesIsNotTold) {
  auto& owner = component(70000);
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:*"}, {"min", 1000}});
  scheduler.run_for(1s);
  ASSERT_TRUE(owner.set("x", "1"));
  scheduler.run_for(1s);
  page.take_frames();
  ASSERT_TRUE(owner.set("a", "1"));
  scheduler.run_for(10ms);
  page.take_frames();
  ASSERT_TRUE(owner.set("b", "1"));
  scheduler.run_for(10ms);
  ASSERT_TRUE(owner.erase("b"));
  scheduler.run_for(2s);
  for (const auto& frame : page.frames) EXPECT_FALSE(frame.contains("s")) << frame;
}

TEST_F(Subscriptions, AnOwnerThatIsLostIsAbsentAndPresentAgain) {
  start_lamp();
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "*:proxy.*.*.status"}});
  scheduler.run_for(1s);
  page.take_frames();
  ecology.cut(OwnerId(1), OwnerId(kSite));
  scheduler.run_for(1s);
  ASSERT_EQ(page.frames.size(), 1U);
  EXPECT_EQ(page.frames[0], Json({{"s", 1}, {"absent", {1}}}));
  page.take_frames();
  ecology.mend(OwnerId(1), OwnerId(kSite));
  scheduler.run_for(1s);
  EXPECT_EQ(page.frames.at(0)["present"], Json::array({1}));
  EXPECT_EQ(page.frames.back()["snapshot"], 1);
  page.take_frames();
  ecology.cut(OwnerId(1), OwnerId(kSite));
  scheduler.run_for(60s);
  std::vector<Json> gone;
  for (const auto& frame : page.frames) {
    if (frame.contains("gone")) gone.push_back(frame["gone"]);
  }
  ASSERT_EQ(gone.size(), 1U) << "after the grace the copies end";
  EXPECT_EQ(gone[0][0][1], "lost");
  page.take_frames();
  ecology.mend(OwnerId(1), OwnerId(kSite));
  scheduler.run_for(1s);
  ASSERT_FALSE(page.frames.empty());
  for (const auto& frame : page.frames) EXPECT_FALSE(frame.contains("present")) << "it was forgotten: " << frame;
  EXPECT_EQ(page.frames.back()["snapshot"], 1);
}

TEST_F(Subscriptions, AnOwnerWithoutTuplesThatIsBackBeforeTheNextFrameWasNeverAbsent) {
  start_lamp();
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "*:no.such.tuple"}, {"min", 1000}});
  scheduler.run_for(2s);
  page.take_frames();
  page.read(false);
  ecology.cut(OwnerId(1), OwnerId(kSite));
  scheduler.run_for(1s);
  ecology.mend(OwnerId(1), OwnerId(kSite));
  scheduler.run_for(1s);
  page.read(true);
  scheduler.run_for(2s);
  ASSERT_FALSE(page.frames.empty());
  for (const auto& frame : page.frames) EXPECT_FALSE(frame.contains("absent")) << frame;
}

TEST_F(Subscriptions, WatchingWakesNoSensorUnlessItIsActive) {
  start_lamp();
  auto& page = Sites::page();
  const Json pattern = "1:proxy.*.*.sensor.temperature-1.value";
  page.ask({{"do", "subscribe"}, {"pattern", pattern}});
  scheduler.run_for(1s);
  EXPECT_THAT(devices_of(1).sampled["7"].points, IsEmpty());
  page.ask({{"do", "subscribe"}, {"pattern", pattern}, {"active", true}, {"min", 2000}});
  scheduler.run_for(1s);
  EXPECT_THAT(devices_of(1).sampled["7"].points, ElementsAre(sensor("temperature")));
  EXPECT_EQ(devices_of(1).sampled["7"].period, 2s);
  page.ask({{"do", "unsubscribe"}, {"subscription", 2}});
  scheduler.run_for(1s);
  EXPECT_THAT(devices_of(1).sampled["7"].points, IsEmpty());
}

TEST_F(Subscriptions, FullTellsWhereAValueCameFrom) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("a", "{}", {.media_type = "application/json", .lifetime = 60s}));
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:a"}, {"full", true}});
  scheduler.run_for(100ms);
  const auto more = page.frames.at(1)["set"][0][4];
  EXPECT_EQ(more["m"], "application/json");
  EXPECT_EQ(more["c"], 70000);
  EXPECT_EQ(more["p"], true);
  EXPECT_NEAR(more["e"].get<double>() - more["w"].get<double>(), 60, 1e-3);
}

TEST_F(Subscriptions, ValuesThatAreNoTextOrLongAreSentByTheirSize) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("bytes", "\xff\xfe", {.media_type = "image/png"}));
  ASSERT_TRUE(owner.set("long", std::string((kMaxSentValue + 1), 'x')));
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "70000:*"}});
  scheduler.run_for(100ms);
  const auto sets = page.sets();
  EXPECT_EQ(sets.at("70000:bytes")[1], nullptr);
  EXPECT_EQ(sets.at("70000:bytes")[4], Json({{"size", 2}, {"m", "image/png"}}));
  EXPECT_EQ(sets.at("70000:long")[1], nullptr);
  EXPECT_EQ(sets.at("70000:long")[4], Json({{"size", (kMaxSentValue + 1)}, {"m", "text/plain"}}));
}

TEST_F(Subscriptions, TwoIslandsHaveASnapshotEach) {
  start_lamp();
  start_island(2);
  auto& page = Sites::page();
  page.ask({{"do", "subscribe"}, {"pattern", "*:proxy.island"}});
  scheduler.run_for(1s);
  std::vector<int> snapshots;
  for (const auto& frame : page.frames) {
    if (frame.contains("snapshot")) snapshots.push_back(frame["snapshot"]);
  }
  EXPECT_THAT(snapshots, testing::UnorderedElementsAre(1, 2));
}

TEST_F(Subscriptions, AConnectionHasAtMost256) {
  auto& page = Sites::page();
  for (int i = 0; i < 256; ++i) page.ask({{"do", "subscribe"}, {"pattern", "*:x"}});
  const auto id = page.ask({{"do", "subscribe"}, {"pattern", "*:x"}});
  EXPECT_EQ(page.answer(id)["error"]["code"], "busy");
  EXPECT_THAT(page.answer(id)["error"]["text"].get<std::string>(), HasSubstr("256"));
}

TEST_F(Subscriptions, TheTuplesOfAllThatAConnectionHasAreBounded) {
  auto& owner = component(70000);
  for (int i = 0; i < 1250; ++i) ASSERT_TRUE(owner.set("t" + std::to_string(i), "x"));
  auto& page = Sites::page();
  for (int i = 0; i < 239; ++i) page.ask({{"do", "subscribe"}, {"pattern", "70000:*"}, {"min", 1000}});
  scheduler.run_for(100ms);
  EXPECT_EQ(page.closed, "");
  page.ask({{"do", "unsubscribe"}, {"subscription", 1}});
  for (int i = 0; i < 2; ++i) page.ask({{"do", "subscribe"}, {"pattern", "70000:*"}, {"min", 1000}});
  scheduler.run_for(100ms);
  EXPECT_EQ(page.closed, "") << "300,000 are permitted, and an end makes room";
  page.ask({{"do", "subscribe"}, {"pattern", "70000:t1"}});
  scheduler.run_for(100ms);
  EXPECT_THAT(page.closed, HasSubstr("300,000 tuples"));
}

TEST_F(Subscriptions, TheEndOfAConnectionEndsItsSubscriptions) {
  auto& page = Sites::page();
  const auto before = component(kSite).stats().subscriptions;
  page.ask({{"do", "subscribe"}, {"pattern", "*:x.**"}, {"active", true}});
  scheduler.run_for(1s);
  EXPECT_GT(component(kSite).stats().subscriptions, before);
  close(page);
  scheduler.run_for(1s);
  EXPECT_EQ(component(kSite).stats().subscriptions, before);
}

}  // namespace
}  // namespace rubicon::web::api
