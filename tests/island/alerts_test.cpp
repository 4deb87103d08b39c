#include "island/alerts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "virtual_island.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;
using model::AlertList;

TEST(IslandAlerts, AreATupleThatFollowsTheirCause) {
  VirtualIsland at("{attic: {keepalive: 1h, sensors: {light-1: {value: 3}}}, den: {keepalive: 1s}}");
  std::vector<AlertList> seen;
  const auto watch = at.space->subscribe({OwnerId(6541), "proxy.alerts"}, {}, [&](const tuples::Event& event) {
    if (event.kind == tuples::EventKind::kSet) seen.push_back(model::alerts_from_json(event.tuple.value));
  });
  at.time.run_for(10s);
  ASSERT_EQ(seen.size(), 1U) << "one that does not change is not written again";
  EXPECT_TRUE(seen[0].all.empty());
  at.time.run_for(2min);
  ASSERT_EQ(seen.size(), 2U);
  ASSERT_EQ(seen[1].all.size(), 1U);
  EXPECT_EQ(seen[1].all[0].about, "proxy.dummy-1.attic");
}

TEST(IslandAlerts, WhatHasNoDateIsThereSinceItWasFirstSeen) {
  VirtualIsland at("{den: {keepalive: 1s}}");
  Alerts alerts(at.time, *at.space, "own");
  bool full = false;
  alerts.add([&full](AlertList& list) { add_disk("own", {"the state file", full ? 1U : 100'000'000U}, list); });
  alerts.start();
  const auto shown = [&at] {
    const auto tuple = at.space->get(at.space->self(), "own.alerts");
    return model::alerts_from_json(tuple ? tuple->value : std::string_view()).all;
  };
  at.time.run_for(10s);
  EXPECT_TRUE(shown().empty());
  full = true;
  at.time.run_for(2s);
  ASSERT_EQ(shown().size(), 1U);
  const auto since = shown()[0].since;
  EXPECT_GT(since, at.time.wall_now() - 4s);
  at.time.run_for(1h);
  EXPECT_EQ(shown()[0].since, since);
  full = false;
  at.time.run_for(2s);
  full = true;
  at.time.run_for(2s);
  EXPECT_GT(shown().at(0).since, since + 1h) << "it is another one";
}

TEST(IslandAlerts, OfADiskARecorderAndAClock) {
  AlertList list;
  add_disk("proxy.state", {"the state file", 100'000'000}, list);
  add_disk("proxy.state", {"the state file", std::nullopt}, list);
  add_clock("proxy", WallTime(std::chrono::seconds(1'600'000'000)), list);
  for (const auto* state : {"recording", "opening", "stopped"})
    add_unwritten("proxy.history", R"({"state":")" + std::string(state) + R"("})", list);
  EXPECT_EQ(list, AlertList());
  add_disk("proxy.state", {"the state file", 99'999'999}, list);
  add_unwritten("proxy.recorder.all", R"({"state":"dropping","file":"/var/all.rlog","reason":"disk full","since":9})",
                list);
  add_clock("proxy", WallTime(std::chrono::seconds(86400)), list);
  std::vector<std::string> kinds;
  for (const auto& one : list.all) kinds.push_back(one.kind);
  EXPECT_EQ(kinds, (std::vector<std::string>{"disk-full", "not-written", "clock"}));
  EXPECT_EQ(list.all[1].what, "/var/all.rlog is not written: disk full");
  EXPECT_EQ(list.all[1].since, WallTime(std::chrono::seconds(9)));
}

TEST(IslandAlerts, OfABridgeAnInterfaceAndAnIslandThatIsHeldBack) {
  VirtualIsland at("{den: {}}");
  auto& space = at.island->space();
  const auto kinds_with = [&](const std::string& bridge, const std::string& lack) {
    EXPECT_TRUE(space.set("proxy.bridge.ha.status", bridge));
    EXPECT_TRUE(space.set("proxy.property.dds-interfaces.value",
                          R"({"interfaces":[{"name":"lo","lack":""},{"name":"eth0","lack":")" + lack + R"("}]})"));
    at.time.run_for(3s);
    std::vector<std::string> all;
    for (const auto& one : model::alerts_from_json(space.get(space.self(), "proxy.alerts")->value).all)
      all.push_back(one.kind + " " + one.about);
    return all;
  };
  using Kinds = std::vector<std::string>;
  EXPECT_EQ(kinds_with(R"({"state":"up","reason":"the broker retains nothing"})", ""), Kinds());
  EXPECT_EQ(kinds_with(R"({"state":"connecting","reason":""})", ""), Kinds());
  EXPECT_EQ(kinds_with(R"({"state":"connecting","reason":"refused"})", ""), Kinds{"bridge-down proxy.bridge.ha"});
  EXPECT_EQ(kinds_with(R"({"state":"up"})", "is down"), Kinds{"interface-down proxy.property.dds-interfaces.eth0"});
  AlertList list;
  add_held_back("proxy", "", list);
  EXPECT_EQ(list, AlertList());
  add_held_back("proxy", "tuples.trust", list);
  EXPECT_EQ(list.all.at(0).kind, "held-back");
}

TEST(IslandAlerts, WritesOfTheStateFileThatFailAreOneUntilTheySucceed) {
  StateFailures failures;
  const SteadyTime start{1h};
  const auto is_one = [&](SteadyTime since) {
    AlertList list;
    failures.add("proxy.state", since, list);
    return list.all.size() == 1;
  };
  failures.look(0, start);
  EXPECT_FALSE(is_one(start - 20s));
  failures.look(3, start + 1s);
  EXPECT_TRUE(is_one(start - 19s));
  failures.look(3, start + 30s);
  EXPECT_FALSE(is_one(start + 10s));
}

}  // namespace
}  // namespace rubicon::island
