#include "scenarios/roaming.h"

#include <gmock/gmock.h>

namespace rubicon::scenarios {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

TEST_F(Roaming, ADeviceThatJoinsAnotherIslandMovesThereWithinASecond) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(1);
  scheduler.run_for(10s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2));
  EXPECT_LE(list.overlap(), 1s);
  EXPECT_EQ(value(islands[1]->space(), 1, "proxy.scripted-1.7.sensor.light-1.value"), "(none)");
  EXPECT_EQ(value(islands[1]->space(), 1, "ROAMING.lab.7"), "(none)");
  join(1);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1)) << "and back";
}

TEST_F(Roaming, AClaimShowsWhereTheDeviceIs) {
  start_text(1, "networks: {scripted-hall: {type: scripted, roaming: lab, devices: {1.4.6: {id: lamp}}}}");
  ScriptedNetwork::of(1, "scripted-hall").say("1.4.6", lamp());
  scheduler.run_ready();
  const auto said = claim(1, "1_4_6");
  EXPECT_EQ(said["key"], "proxy.scripted-hall.lamp");
  EXPECT_EQ(said["network"], "scripted-hall");
  EXPECT_EQ(said["device"], "lamp");
  EXPECT_EQ(said["address"], "1.4.6");
  EXPECT_EQ(said["since"], 1767225600);
  EXPECT_EQ(said["reachable"], true);
}

TEST_F(Roaming, AClientFollowsADeviceByItsIdentity) {
  start_island(1, kLab);
  start_island(2, kLab);
  std::vector<std::uint32_t> places;
  auto ears = watcher().subscribe({std::nullopt, "ROAMING.lab.7"}, {.passive = true}, [&](const Event& event) {
    if (event.kind == EventKind::kSet && (places.empty() || places.back() != number(event.tuple.owner)))
      places.push_back(number(event.tuple.owner));
  });
  for (const auto island : {1U, 2U, 1U}) {
    join(island);
    scheduler.run_for(5s);
  }
  EXPECT_THAT(places, ElementsAre(1, 2, 1));
}

TEST_F(Roaming, OfTwoThatHearOneJoinAtATimeTheLowerIslandListsItAlsoAfterACut) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(1);
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
  EXPECT_LE(list.overlap(), 1s);
  ecology.cut(OwnerId(1), OwnerId(2));
  for (int i = 0; i < 6; ++i) {
    word(1);
    word(2);
    scheduler.run_for(5s);
  }
  EXPECT_THAT(list.owners(), ElementsAre(1, 2)) << "each side of the cut serves it";
  ecology.mend(OwnerId(1), OwnerId(2));
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
}

TEST_F(Roaming, TheNewestJoinWinsWhenACutIsMended) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  ecology.cut(OwnerId(1), OwnerId(2));
  join(1);
  scheduler.run_for(1s);
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1, 2));
  ecology.mend(OwnerId(1), OwnerId(2));
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2));
}

TEST_F(Roaming, AJoinThatBothHearAgainAndAgainStaysWhereItIs) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(2);
  scheduler.run_for(5s);
  for (int i = 0; i < 100; ++i) {
    join(i % 2 == 0 ? 1 : 2);
    scheduler.run_for(50ms);
    join(i % 2 == 0 ? 2 : 1);
    scheduler.run_for(10s);
  }
  EXPECT_THAT(list.owners(), ElementsAre(2));
  EXPECT_EQ(list.begins(), 1);
}

TEST_F(Roaming, JoinsRepeatedByTwoNetworksForEverDoNotMoveItForEver) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  const auto hour = [this] {
    for (int i = 0; i < 360; ++i) {
      join(1);
      scheduler.run_for(5s);
      join(2);
      scheduler.run_for(5s);
    }
  };
  hour();
  const auto begins = list.begins();
  EXPECT_LE(begins, 7);
  hour();
  EXPECT_EQ(list.begins(), begins) << "it has settled";
  EXPECT_THAT(list.owners(), SizeIs(1));
}

TEST_F(Roaming, ADeviceThatWandersForADayIsAlwaysFollowed) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  for (int i = 0; i < 100; ++i) {
    const auto here = static_cast<std::uint32_t>(i % 2 + 1);
    join(here);
    for (int words = 0; words < 10; ++words) {
      scheduler.run_for(10s);
      word(here);
    }
    scheduler.run_for(1s);
    EXPECT_THAT(list.owners(), ElementsAre(here)) << "visit " << i;
  }
  EXPECT_LE(list.overlap(), 1s);
}

TEST_F(Roaming, InAnotherDomainOrNoneAnAddressIsNoIdentity) {
  start_island(1, kLab);
  start_island(2, "roaming: cellar");
  start_island(3);
  start_island(4, "roaming: off");
  const auto list = listing();
  for (std::uint32_t island = 1; island <= 4; ++island) {
    join(island);
    scheduler.run_for(1s);
  }
  EXPECT_THAT(list.owners(), ElementsAre(1, 2, 3, 4));
}

TEST_F(Roaming, TwoAddressesWithOneKeyPartAreTwoDevices) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing("1_7");
  join(1, "1.7");
  scheduler.run_for(1s);
  join(2, "1_7");
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1, 2));
  start_text(3, "networks: {scripted-1: {type: scripted, roaming: lab, devices: {1.7: {id: a}, 1_7: {id: b}}}}");
  join(3, "1.7");
  join(3, "1_7");
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), IsEmpty()) << "both went to island 3";
  EXPECT_EQ(claim(3, "1_7")["address"], "1.7");
  EXPECT_EQ(claim(3, "1_7-2")["address"], "1_7");
}

TEST_F(Roaming, ReadingsOfADeviceElsewhereAreCountedNotListed) {
  start_island(1, kLab);
  auto& b = start_island(2, kLab);
  const auto list = listing();
  join(2);
  scheduler.run_for(5s);
  join(1);
  for (int i = 0; i < 10; ++i) {
    scheduler.run_for(5s);
    word(1);
    devices_of(2).say("7", reading(sensor("light"), 300.0));
  }
  scheduler.run_for(2s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
  EXPECT_EQ(value(b.space(), 2, "proxy.scripted-1.property.roamed-messages.value"), "10");
  EXPECT_EQ(value(b.space(), 2, "proxy.scripted-1.property.unknown-devices.value"), "0");
}

TEST_F(Roaming, WhenTheOtherIslandRemovesItTheOneThatHearsItListsIt) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(1);
  scheduler.run_for(5s);
  join(2);
  scheduler.run_for(5s);
  devices_of(2).say("7", model::Leave{"going"});
  scheduler.run_for(5s);
  EXPECT_THAT(list.owners(), IsEmpty()) << "nobody has heard it";
  word(1);
  scheduler.run_ready();
  EXPECT_THAT(list.owners(), ElementsAre(1));
}

TEST_F(Roaming, AnIslandThatDoesNotHearItGivesWayToOneThatDoes) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(1);
  scheduler.run_for(5s);
  join(2);
  for (int i = 0; i < 5; ++i) {
    scheduler.run_for(10s);
    word(1);
  }
  EXPECT_THAT(list.owners(), ElementsAre(2));
  for (int i = 0; i < 3; ++i) {  // silent for a minute at island 2
    scheduler.run_for(10s);
    word(1);
  }
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
  EXPECT_EQ(list.begins(), 3);
}

TEST_F(Roaming, ASleepingDeviceThatBothHearWakingStaysWhereItIs) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(2);
  scheduler.run_for(5s);
  join(1);
  for (int i = 0; i < 20; ++i) {
    scheduler.run_for(5min);
    word(2);
    word(1);
  }
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
  EXPECT_EQ(list.begins(), 2);
}

TEST_F(Roaming, AfterACrashOfItsIslandAnotherListsItOnceTheGraceIsOver) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(1);
  scheduler.run_for(5s);
  join(2);
  scheduler.run_for(5s);
  ecology.cut(OwnerId(1), OwnerId(2));  // how a crash looks to the others
  scheduler.run_for(5s);
  word(1);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2)) << "it may be back in a moment";
  scheduler.run_for(5s);
  word(1);
  scheduler.run_ready();
  EXPECT_THAT(list.owners(), ElementsAre(1, 2));
}

TEST_F(Roaming, AJoinIsListedAtOnceWhenTheOtherIslandIsLost) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(2);
  scheduler.run_for(5s);
  ecology.cut(OwnerId(1), OwnerId(2));
  join(1);
  scheduler.run_ready();
  EXPECT_THAT(list.owners(), ElementsAre(1, 2));
  ecology.mend(OwnerId(1), OwnerId(2));
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
}

TEST_F(Roaming, WhatWentToAnotherIslandIsNotThereAgainAfterARestart) {
  const auto file = state_file();
  start_with_state(1, file);
  start_island(2, kLab);
  const auto list = listing();
  join(1);
  scheduler.run_for(30s);
  join(2);
  scheduler.run_for(30s);
  stop(1);
  start_with_state(1, file);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2));
  stop(2);
  stop(1);
  auto& again = start_with_state(1, file);
  scheduler.run_for(1s);
  EXPECT_EQ(value(again.space(), 1, "proxy.scripted-1.7.status"), "(none)") << "not even when island 2 is away";
}

TEST_F(Roaming, WhatMovedWhileTheIslandWasDownIsGivenUpAtItsStart) {
  const auto file = state_file();
  start_with_state(2, file);
  start_island(3, kLab);
  const auto list = listing();
  join(2);
  scheduler.run_for(30s);
  stop(2);
  join(3);
  scheduler.run_for(1s);
  start_with_state(2, file);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(3));
  EXPECT_LE(list.overlap(), 1s);
}

TEST_F(Roaming, ARestartedIslandKeepsWhatNoOtherLists) {
  const auto file = state_file();
  start_with_state(1, file);
  start_island(2, kLab);
  const auto list = listing();
  join(2);
  scheduler.run_for(5s);
  join(1);
  scheduler.run_for(30s);
  stop(1);
  start_with_state(1, file);
  EXPECT_THAT(list.owners(), ElementsAre(1)) << "stored";
  word(1);
  scheduler.run_for(5s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
}

TEST_F(Roaming, AWrongClockInTheFutureDoesNotKeepADevice) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  const auto today = scheduler.wall_now();
  scheduler.set_wall(today + std::chrono::hours(24 * 365 * 50));
  join(1);
  scheduler.run_for(1s);
  scheduler.set_wall(today);
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2));
  EXPECT_LE(claim(2)["since"].get<double>(), base::to_seconds(scheduler.wall_now())) << "the dispute is over";
  scheduler.run_for(10s);
  join(1);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
}

TEST_F(Roaming, AClockThatIsBehindDoesNotLoseADevice) {
  start_island(1, kLab);
  start_island(2, kLab);
  const auto list = listing();
  join(1);
  scheduler.run_for(10s);
  scheduler.set_wall(scheduler.wall_now() - std::chrono::hours(5));
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2));
}

TEST_F(Roaming, AnIslandThatDoesNotLetItInDoesNotTakeIt) {
  start_island(1, kLab);
  start_text(2, "networks: {scripted-1: {type: scripted, roaming: lab}}\ndiscovery: {new-devices: ask}");
  const auto list = listing();
  join(1);
  scheduler.run_for(5s);
  join(2);
  scheduler.run_for(5s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
  component(70001).set_remote(OwnerId(2), "proxy.inbox.scripted-1.7", "approve", {}, nullptr);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2)) << "its join there was the newest";
}

TEST_F(Roaming, AnOldJoinThatIsApprovedLateDoesNotTakeIt) {
  start_island(1, kLab);
  start_text(2, "networks: {scripted-1: {type: scripted, roaming: lab}}\ndiscovery: {new-devices: ask}");
  const auto list = listing();
  join(2);
  scheduler.run_for(5s);
  join(1);
  scheduler.run_for(5s);
  component(70001).set_remote(OwnerId(2), "proxy.inbox.scripted-1.7", "approve", {}, nullptr);
  scheduler.run_for(5s);
  EXPECT_THAT(list.owners(), ElementsAre(1));
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2)) << "approved is approved";
}

TEST_F(Roaming, TwoNetworksOfOneIslandSettleByTheSameRule) {
  start_text(1, "networks: {scripted-1: {type: scripted, roaming: lab}, scripted-2: {type: scripted, roaming: lab}}");
  const auto list = listing();
  auto& second = ScriptedNetwork::of(1, "scripted-2");
  join(1);
  scheduler.run_for(5s);
  second.say("7", lamp());
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), SizeIs(1));
  EXPECT_EQ(claim(1)["network"], "scripted-2");
  for (int i = 0; i < 10; ++i) {
    join(1);
    second.say("7", lamp());
    scheduler.run_for(10s);
  }
  EXPECT_EQ(claim(1)["network"], "scripted-2") << "both hear it";
  EXPECT_EQ(list.begins(), 2);
}

TEST_F(Roaming, DemandFollowsTheDevice) {
  start_island(1, kLab);
  start_island(2, kLab);
  std::string last;
  auto demand = component(70001).subscribe({std::nullopt, "proxy.*.7.sensor.temperature-1.value"}, {},
                                           [&](const Event& event) { last = event.tuple.value; });
  join(1);
  scheduler.run_for(5s);
  EXPECT_THAT(devices_of(1).sampled["7"].points, SizeIs(1));
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(devices_of(1).sampled["7"].points, IsEmpty()) << "stopped at 1";
  EXPECT_THAT(devices_of(2).sampled["7"].points, ElementsAre(sensor("temperature")));
  devices_of(2).say("7", reading(sensor("temperature"), 21.5));
  scheduler.run_ready();
  EXPECT_EQ(last, "21.5");
  demand.reset();
  scheduler.run_for(1s);
  EXPECT_THAT(devices_of(2).sampled["7"].points, IsEmpty());
}

TEST_F(Roaming, AReloadTurnsItOnAndOff) {
  auto& a = start_island(1, kLab);
  start_island(2);
  const auto list = listing();
  join(1);
  scheduler.run_for(1s);
  join(2);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1, 2));
  base::ConfigErrors errors;
  const auto reload = [&](std::uint32_t id, const std::string& domain) {
    return islands[id]->reload(
        read("island: {id: " + std::to_string(id) +
                 ", name: test}\nnetworks: {scripted-1: {type: scripted, roaming: " + domain + "}}",
             errors),
        errors);
  };
  const auto plan = reload(2, "lab");
  ASSERT_TRUE(plan) << plan.error().text;
  EXPECT_THAT(plan->lines, ElementsAre("network scripted-1: roaming changes from off to lab"));
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2));
  ASSERT_TRUE(reload(2, "cellar"));
  scheduler.run_for(1s);
  word(1);
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1, 2));
  EXPECT_EQ(value(a.space(), 1, "ROAMING.lab.7").substr(0, 1), "{");
  ASSERT_TRUE(reload(2, "lab"));
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(2));
  ASSERT_TRUE(reload(1, "off"));
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1, 2)) << "what it held back comes";
}

TEST_F(Roaming, NonsenseInClaimsOfOthersChangesNothing) {
  start_island(1, kLab);
  const auto list = listing();
  join(1);
  scheduler.run_ready();
  auto& rogue = component(66);
  for (const auto* text :
       {"", "[]", "{", R"({"address":"7"})",
        R"({"key":"proxy.a.7","network":"a","device":"7","address":"7","since":1e300,"reachable":true})",
        R"({"key":"..","network":"a","device":"7","address":"7","since":1767225700,"reachable":true})"}) {
    EXPECT_TRUE(rogue.set("ROAMING.lab.7", text));
    scheduler.run_ready();
    EXPECT_THAT(list.owners(), ElementsAre(1)) << text;
  }
  auto& robot = component(70001);
  EXPECT_TRUE(
      robot.set("ROAMING.lab.7",
                R"({"key":"proxy.a.7","network":"a","device":"7","address":"7","since":1767229999,"reachable":true})"));
  scheduler.run_for(1s);
  EXPECT_THAT(list.owners(), ElementsAre(1)) << "a component that is not an island lists nothing";
}

}  // namespace
}  // namespace rubicon::scenarios
