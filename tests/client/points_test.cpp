#include "client/points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/virtual_scheduler.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::client {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr const char* kJson = "application/json";

Tuple tuple(std::string_view key, std::string_view value, std::uint32_t owner = 1) {
  tuples::TupleView view;
  view.owner = OwnerId(owner);
  view.key = key;
  view.value = value;
  return Tuple(view);
}

TEST(PointsFrom, PutTogetherWhatTheTuplesOfAPointSay) {
  const auto points = points_from(
      {tuple("proxy.wsn-1.7.sensor.light-1.value", "686.6"),
       tuple("proxy.wsn-1.7.sensor.light-1.status", R"({"quality":"stale","reason":"not heard for 3s","heard":5.5})"),
       tuple("proxy.wsn-1.7.sensor.light-1.description", R"({"type":"light","unit":"lx"})"),
       tuple("proxy.wsn-1.status", R"({"line":"down","reason":"no sink"})"), tuple("proxy.wsn-1.7.status", "{}")});
  ASSERT_EQ(points.size(), 1U);
  const auto& point = points[0];
  EXPECT_EQ(point.key(), "proxy.wsn-1.7.sensor.light-1");
  EXPECT_EQ(point.value(), "686.6");
  EXPECT_EQ(point.status.quality, "stale");
  EXPECT_EQ(point.status.reason, "not heard for 3s");
  EXPECT_EQ(point.status.heard, WallTime(5500ms));
  EXPECT_EQ(point.unit, "lx");
  EXPECT_EQ(point.line.reason, "no sink");
  EXPECT_FALSE(point.good());
}

TEST(PointsFrom, AreInNaturalOrderAndOfEachOwnerByItself) {
  std::vector<std::string> keys;
  for (const auto& point : points_from({tuple("p.n-10.a.sensor.x-1.value", ""), tuple("p.n-2.a.sensor.x-10.value", ""),
                                        tuple("p.n-2.a.sensor.x-9.value", ""),
                                        tuple("p.n-2.a.sensor.x-9.status", R"({"quality":"good"})", 2),
                                        tuple("p.n-1.a.sensor.x-1.value", "", 2)})) {
    keys.push_back(point.tuple.key);
    EXPECT_FALSE(point.good());
  }
  EXPECT_THAT(keys, ElementsAre("p.n-2.a.sensor.x-9.value", "p.n-2.a.sensor.x-10.value", "p.n-10.a.sensor.x-1.value",
                                "p.n-1.a.sensor.x-1.value"));
}

TEST(PointsFrom, WhoseIslandIsLostAreNotGood) {
  auto value = tuple("p.n.a.sensor.x-1.value", "1");
  value.owner_present = false;
  const auto points = points_from({value, tuple("p.n.a.sensor.x-1.status", R"({"quality":"good"})")});
  EXPECT_EQ(points.at(0).status.quality, "network-down");
  EXPECT_EQ(points.at(0).status.reason, "island 1 is not there");
}

TEST(PointPatterns, NeedAKeyOfFiveParts) {
  const auto good = point_patterns({OwnerId(1), "proxy.*.living.sensor.*"});
  ASSERT_TRUE(good);
  EXPECT_EQ(good->values.key, "proxy.*.living.sensor.*.value");
  EXPECT_EQ(good->lines.key, "proxy.*.status");
  EXPECT_EQ(good->lines.owner, OwnerId(1));
  for (const auto* bad : {"proxy.*.living.sensor", "proxy.*.living.sensor.*.value", "a.b.c.d.**"}) {
    const auto refused = point_patterns({{}, bad});
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
  }
}

TEST(NetworksFrom, CountTheirDevicesAndKeepTheirProperties) {
  const auto networks = networks_from({tuple("proxy.knx-10.status", R"({"line":"up"})"),
                                       tuple("proxy.knx-9.status", R"({"line":"down","reason":"why","attempts":4})"),
                                       tuple("proxy.knx-9.a.status", R"({"status":"reachable"})"),
                                       tuple("proxy.knx-9.b.status", R"({"status":"unreachable"})"),
                                       tuple("proxy.knx-9.property.bad-frames.value", "3"),
                                       tuple("proxy.knx-9.x.status", R"({"status":"reachable"})", 2),
                                       tuple("robot.arm.status", R"({"pose":1})")});
  ASSERT_EQ(networks.size(), 2U);
  EXPECT_EQ(networks[0].id, "knx-9");
  EXPECT_EQ(networks[0].type(), "knx");
  EXPECT_EQ(networks[0].devices, 2U);
  EXPECT_EQ(networks[0].reachable, 1U);
  EXPECT_EQ(networks[0].line.attempts, 4U);
  EXPECT_THAT(networks[0].properties, ElementsAre(testing::Pair("bad-frames", "3")));
  EXPECT_EQ(networks[1].id, "knx-10");
}

TEST(ListOfDevices, ReachableOnesComeFirstThenInNaturalOrder) {
  std::vector<Device> devices;
  const auto add = [&](const char* network, const char* id, const char* status) {
    auto& device = devices.emplace_back();
    device.network = network;
    device.id = id;
    device.status = status;
  };
  add("knx", "a", "unknown");
  add("wsn-10", "1", "reachable");
  add("wsn-2", "10", "reachable");
  add("knx", "b", "unreachable");
  add("wsn-2", "9", "reachable");
  std::sort(devices.begin(), devices.end(), listed_before);
  std::vector<std::string> order;
  for (const auto& device : devices) order.push_back(device.network + "." + device.id);
  EXPECT_THAT(order, ElementsAre("wsn-2.9", "wsn-2.10", "wsn-10.1", "knx.b", "knx.a"));
}

/// Island 1, played by hand, with one sensor, and a component that watches it.
struct WatchedPoints : testing::Test {
  static constexpr OwnerId kIsland{1};
  const std::string kPoint = "proxy.wsn-1.7.sensor.light-1";

  struct Member {
    Member(tuples::MemoryEcology& ecology, VirtualScheduler& scheduler, std::uint32_t id)
        : link(std::move(*ecology.join(OwnerId(id)))), space(OwnerId(id), scheduler, *link) {}
    std::unique_ptr<tuples::Link> link;
    TupleSpace space;
  };

  void value(const std::string& text) { ASSERT_TRUE(island->space.set(kPoint + ".value", text)); }
  void quality(const std::string& word, const std::string& reason = "", int heard = 1) {
    ASSERT_TRUE(island->space.set(
        kPoint + ".status",
        R"({"quality":")" + word + R"(","reason":")" + reason + R"(","heard":)" + std::to_string(heard) + "}",
        {kJson}));
  }
  void line(const std::string& word, const std::string& reason = "", int attempts = 1) {
    ASSERT_TRUE(island->space.set(
        "proxy.wsn-1.status",
        R"({"line":")" + word + R"(","reason":")" + reason + R"(","attempts":)" + std::to_string(attempts) + "}",
        {kJson}));
  }
  void SetUp() override {
    line("up");
    value("20");
    quality("good");
    watch({.passive = true});
    time.run_for(10ms);
  }
  void watch(const Flow& flow) {
    told.clear();
    watching = std::make_unique<PointWatch>(time, self.space, *point_patterns({{}, "proxy.*.*.*.*"}), flow,
                                            [this](PointEvent event, const Point& point) { take(event, point); });
  }
  void take(PointEvent event, const Point& point) {
    const auto* word = event == PointEvent::kValue ? "value " : event == PointEvent::kState ? "state " : "gone ";
    told.push_back(word + point.value() + " " + point.status.quality +
                   (point.status.reason.empty() ? "" : ": " + point.status.reason) +
                   (point.line.line == "up" ? "" : " line " + point.line.line));
  }
  std::vector<std::string> news() {
    time.run_for(10ms);
    return std::exchange(told, {});
  }

  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<Member> island = std::make_unique<Member>(ecology, time, 1);
  Member self{ecology, time, 70000};
  std::vector<std::string> told;
  std::unique_ptr<PointWatch> watching;
};

TEST_F(WatchedPoints, WhatIsThereIsToldOnceWithItsQualityAndLine) {
  EXPECT_THAT(news(), ElementsAre("value 20 good"));
  EXPECT_THAT(news(), IsEmpty());
}

TEST_F(WatchedPoints, ThatAnEventIsOverIsNoNews) {
  news();
  ASSERT_TRUE(island->space.set(kPoint + ".description", R"({"type":"action","report":"event"})", {kJson}));
  news();
  value("toggle");
  EXPECT_THAT(news(), ElementsAre("value toggle good"));
  value("");
  EXPECT_THAT(news(), IsEmpty());
  value("toggle");
  EXPECT_THAT(news(), ElementsAre("value toggle good"));
  value("");
  watch({.passive = true});
  EXPECT_THAT(news(), ElementsAre("state  good")) << "who looks later finds no event";
}

TEST_F(WatchedPoints, OfEventsThatAppearHaveNoEventYet) {
  news();
  const std::string button = "proxy.wsn-1.7.sensor.button-1";
  ASSERT_TRUE(island->space.set(button + ".value", ""));  // in the order in which an island declares a point
  ASSERT_TRUE(island->space.set(button + ".status", R"({"quality":"unknown"})", {kJson}));
  ASSERT_TRUE(island->space.set(button + ".description", R"({"type":"button","report":"event"})", {kJson}));
  EXPECT_THAT(news(), ElementsAre("state  unknown"));
}

TEST_F(WatchedPoints, AChangeOfQualityIsToldThoughTheValueStays) {
  news();
  quality("stale", "not heard for 3s");
  EXPECT_THAT(news(), ElementsAre("state 20 stale: not heard for 3s"));
  quality("device-offline", "silent for 60s");
  EXPECT_THAT(news(), ElementsAre("state 20 device-offline: silent for 60s"));
  quality("good");
  EXPECT_THAT(news(), ElementsAre("state 20 good"));
}

TEST_F(WatchedPoints, ThatIsHeardAgainIsNoNews) {
  news();
  quality("good", "", 2);
  EXPECT_THAT(news(), IsEmpty());
  line("up", "", 2);
  EXPECT_THAT(news(), IsEmpty());
}

TEST_F(WatchedPoints, AValueAndTheQualityThatCameWithItAreOneEvent) {
  news();
  value("21");
  quality("bad", "above 100");
  EXPECT_THAT(news(), ElementsAre("value 21 bad: above 100"));
  value("22");
  quality("good");
  EXPECT_THAT(news(), ElementsAre("value 22 good"));
  value("22");
  EXPECT_THAT(news(), ElementsAre("value 22 good"));
}

TEST_F(WatchedPoints, ALineThatGoesDownIsToldWithEachPoint) {
  news();
  line("down", "no sink");
  EXPECT_THAT(news(), ElementsAre("state 20 good line down"));
  line("up");
  EXPECT_THAT(news(), ElementsAre("state 20 good"));
}

TEST_F(WatchedPoints, AValueThatThePaceHoldsBackIsNotCalledGoodBeforeItComes) {
  quality("stale", "not heard for 3s");
  watch({.minimum = 1s});
  EXPECT_THAT(news(), ElementsAre("value 20 stale: not heard for 3s"));
  value("21");
  quality("good");
  EXPECT_THAT(news(), IsEmpty()) << "20 is not good, 21 is not here yet";
  time.run_for(1s);
  EXPECT_THAT(news(), ElementsAre("value 21 good"));
}

TEST_F(WatchedPoints, OfAnIslandThatIsLostAreNotGoodUntilItIsBack) {
  news();
  island.reset();
  EXPECT_THAT(news(), ElementsAre("state 20 network-down: island 1 is not there line "));
  island = std::make_unique<Member>(ecology, time, 1);
  line("up");
  value("22");
  quality("good");
  EXPECT_THAT(news(), ElementsAre("value 22 good"));
}

TEST_F(WatchedPoints, OfAnIslandThatWasLostBeforeTheWatchBeganAreNotGoodUntilItIsBack) {
  const auto copies = self.space.subscribe({{}, "proxy.**"}, {.passive = true}, [](const tuples::Event&) {});
  news();
  island.reset();
  news();
  watch({.passive = true});
  EXPECT_THAT(news(), ElementsAre("value 20 network-down: island 1 is not there line "));
  island = std::make_unique<Member>(ecology, time, 1);
  line("up");
  value("22");
  quality("good");
  EXPECT_THAT(news(), ElementsAre("value 22 good"));
  island.reset();
  news();
  watch({.passive = true});
  news();
  time.run_for(2min);
  EXPECT_THAT(told, ElementsAre("gone 22 network-down: island 1 is not there line "));
}

TEST_F(WatchedPoints, ThatLeaveAreToldOnce) {
  news();
  island->space.erase({{}, "proxy.wsn-1.7.**"});
  EXPECT_THAT(news(), ElementsAre("gone 20 good"));
}

TEST_F(WatchedPoints, AreWantedUnlessTheWatchIsPassive) {
  std::vector<std::string> wanted;
  const auto demand = island->space.watch_demand({{}, "**"}, [&](const tuples::Demand& one) {
    if (one.wanted) wanted.emplace_back(one.key);
  });
  news();
  EXPECT_THAT(wanted, IsEmpty());
  watch({});
  time.run_for(10ms);
  EXPECT_THAT(wanted, ElementsAre(kPoint + ".value"));
}

TEST_F(WatchedPoints, DevicesAreToldAgainWhenTheirLineOrTheReasonChanges) {
  std::vector<std::string> devices;
  ASSERT_TRUE(island->space.set("proxy.wsn-1.7.description", R"({"name":"Kitchen"})", {kJson}));
  ASSERT_TRUE(island->space.set("proxy.wsn-1.7.status", R"({"status":"reachable"})", {kJson}));
  const DeviceWatch follows(self.space, {}, [&](const Device& device, bool) {
    devices.push_back(device.status + " " + device.reason + " " + device.line.line + " " + device.line.reason);
  });
  time.run_for(10ms);
  EXPECT_EQ(devices.back(), "reachable  up ");
  devices.clear();
  line("down", "no sink");
  time.run_for(10ms);
  ASSERT_TRUE(island->space.set("proxy.wsn-1.7.status", R"({"status":"unreachable","reason":"silent"})", {kJson}));
  time.run_for(10ms);
  EXPECT_THAT(devices, ElementsAre("reachable  down no sink", "unreachable silent down no sink"));
}

}  // namespace
}  // namespace rubicon::client
