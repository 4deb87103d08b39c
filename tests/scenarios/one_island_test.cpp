#include <random>
#include <set>

#include "scenarios/ecology.h"

namespace rubicon::scenarios {
namespace {

constexpr auto* kValue = "proxy.scripted-1.7.sensor.temperature-1.value";
constexpr auto* kCommand = "proxy.scripted-1.7.actuator.switch-1.command";
constexpr auto* kState = "proxy.scripted-1.7.actuator.switch-1.value";
constexpr auto* kStatus = "proxy.scripted-1.7.actuator.switch-1.status";

class OneIsland : public Ecology {
 public:
  void SetUp() override {
    start_island(1);
    devices_of(1).say("7", lamp());
    all_ = component(70000).subscribe({OwnerId(1), "**"}, {{}, {}, 0, true}, [](const Event&) {});
    scheduler.run_ready();
  }
  void say(model::PointId id, Value value, WallTime user = {}) {
    devices_of(1).say("7", reading(std::move(id), std::move(value), user));
    scheduler.run_ready();
  }
  std::string seen(const std::string& key) { return value(component(70000), 1, key); }
  nlohmann::json command_state() { return json(component(70000), 1, kStatus)["command"]; }
  tuples::Verdict command(const std::string& text) {
    auto verdict = tuples::Verdict::kExpired;
    component(70000).set_remote(OwnerId(1), kCommand, text, {},
                                [&](const tuples::Reply& reply) { verdict = reply.verdict; });
    scheduler.run_ready();
    return verdict;
  }
  Handle all_;
};

TEST_F(OneIsland, ADeviceIsFullyVisibleFromItsJoinOn) {
  EXPECT_EQ(seen(kValue), "");
  EXPECT_EQ(json(component(70000), 1, "proxy.scripted-1.7.sensor.temperature-1.status")["quality"], "unknown");
  EXPECT_EQ(json(component(70000), 1, "proxy.scripted-1.7.sensor.temperature-1.description")["unit"], "Cel");
  EXPECT_EQ(json(component(70000), 1, "proxy.scripted-1.7.status")["status"], "reachable");
  EXPECT_EQ(seen("proxy.scripted-1.devices"), "[\"7\"]");
}

TEST_F(OneIsland, SamplingStartsWithTheFirstSubscriberAndStopsWithTheLast) {
  EXPECT_FALSE(devices_of(1).sampled.contains("7"));
  Flow fast;
  fast.minimum = 200ms;
  auto first = component(70001).subscribe({OwnerId(1), kValue}, {}, [](const Event&) {});
  scheduler.run_ready();
  ASSERT_EQ(devices_of(1).sampled["7"].points, std::vector{sensor("temperature")});
  EXPECT_EQ(devices_of(1).sampled["7"].period, 1s);
  auto second = component(70002).subscribe({std::nullopt, "proxy.*.7.sensor.*.value"}, fast, [](const Event&) {});
  scheduler.run_ready();
  EXPECT_EQ(devices_of(1).sampled["7"].points.size(), 2U);
  EXPECT_EQ(devices_of(1).sampled["7"].period, 200ms);
  second.reset();
  scheduler.run_ready();
  EXPECT_EQ(devices_of(1).sampled["7"].points, std::vector{sensor("temperature")});
  first.reset();
  scheduler.run_ready();
  EXPECT_TRUE(devices_of(1).sampled["7"].points.empty());
}

TEST_F(OneIsland, ASubscriberThatNamesNoPeriodDoesNotSlowDownOneThatDoes) {
  Flow fast;
  fast.minimum = 100ms;
  auto unhurried = component(70001).subscribe({OwnerId(1), kValue}, {}, [](const Event&) {});
  auto hurried = component(70002).subscribe({OwnerId(1), kValue}, fast, [](const Event&) {});
  scheduler.run_ready();
  EXPECT_EQ(devices_of(1).sampled["7"].period, 100ms);
  hurried.reset();
  scheduler.run_ready();
  EXPECT_EQ(devices_of(1).sampled["7"].period, 1s);
}

TEST_F(OneIsland, ACrashedSubscribersDemandEndsToo) {
  auto demand = component(70001).subscribe({OwnerId(1), kValue}, {}, [](const Event&) {});
  scheduler.run_ready();
  EXPECT_EQ(devices_of(1).sampled["7"].points.size(), 1U);
  crash(70001);
  scheduler.run_ready();
  EXPECT_TRUE(devices_of(1).sampled["7"].points.empty());
}

TEST_F(OneIsland, APassiveSubscriberSeesButDoesNotSample) {
  EXPECT_FALSE(devices_of(1).sampled.contains("7"));  // the test's own view of everything is passive
  say(sensor("temperature"), 21.5);
  EXPECT_EQ(seen(kValue), "21.5");
}

TEST_F(OneIsland, AfterTenThousandRandomSubscriptionsExactlyTheDemandedIsSampled) {
  for (int device = 0; device < 20; ++device) devices_of(1).say(std::to_string(100 + device), lamp());
  scheduler.run_ready();
  std::mt19937 random(11);
  std::vector<std::pair<std::string, Handle>> live;
  const auto key = [&] {
    const auto device = random() % 8 == 0 ? std::string("*") : std::to_string(100 + random() % 20);
    const auto* type = random() % 8 == 0 ? "*" : random() % 2 == 0 ? "temperature-1" : "light-1";
    return "proxy.scripted-1." + device + ".sensor." + type + ".value";
  };
  for (int step = 0; step < 10000; ++step) {
    if (live.size() > 60 || (!live.empty() && random() % 2 == 0)) {
      live.erase(live.begin() + static_cast<std::ptrdiff_t>(random() % live.size()));
    } else {
      const auto pattern = key();
      live.emplace_back(pattern, component(static_cast<std::uint32_t>(70001 + random() % 3))
                                     .subscribe({OwnerId(1), pattern}, {}, [](const Event&) {}));
    }
    if (step % 16 == 0) scheduler.run_ready();
  }
  while (live.size() > 12) live.pop_back();
  scheduler.run_for(1s);
  std::set<std::string> wanted;
  std::set<std::string> sampled;
  for (int device = 100; device < 120; ++device) {
    for (const std::string type : {"temperature", "light"}) {
      const auto full = "proxy.scripted-1." + std::to_string(device) + ".sensor." + type + "-1.value";
      for (const auto& [pattern, handle] : live) {
        if (Pattern{OwnerId(1), pattern}.matches(OwnerId(1), full)) wanted.insert(full);
      }
      for (const auto& id : devices_of(1).sampled[std::to_string(device)].points) {
        if (id == sensor(type)) sampled.insert(full);
      }
    }
  }
  EXPECT_FALSE(wanted.empty());
  EXPECT_EQ(sampled, wanted);
}

TEST_F(OneIsland, ASilentDeviceBecomesUnreachableAndReturnsWithItsFirstWord) {
  auto demand = component(70001).subscribe({OwnerId(1), kValue}, {}, [](const Event&) {});
  say(sensor("temperature"), 21.5);
  scheduler.run_for(61s);
  EXPECT_EQ(json(component(70000), 1, "proxy.scripted-1.7.status")["status"], "unreachable");
  const auto lost = json(component(70000), 1, "proxy.scripted-1.7.sensor.temperature-1.status");
  EXPECT_EQ(lost["quality"], "device-offline");
  EXPECT_EQ(seen(kValue), "21.5") << "the last value stays readable";
  EXPECT_EQ(seen("proxy.scripted-1.devices"), "[]");
  devices_of(1).sampled.clear();
  devices_of(1).say("7", model::KeepAlive{});
  scheduler.run_for(1s);
  EXPECT_EQ(json(component(70000), 1, "proxy.scripted-1.7.status")["status"], "reachable");
  EXPECT_EQ(devices_of(1).sampled["7"].points.size(), 1U) << "what was demanded is asked for again";
  EXPECT_EQ(seen("proxy.scripted-1.devices"), "[\"7\"]");
}

TEST_F(OneIsland, ARejoinWithOtherCapabilitiesKeepsWhatStays) {
  say(sensor("temperature"), 21.5);
  auto join = lamp();
  join.capabilities[1] = capability(sensor("humidity"));
  devices_of(1).say("7", join);
  scheduler.run_ready();
  EXPECT_EQ(seen(kValue), "21.5");
  EXPECT_EQ(seen("proxy.scripted-1.7.sensor.humidity-1.value"), "");
  EXPECT_EQ(seen("proxy.scripted-1.7.sensor.light-1.value"), "(none)");
}

TEST_F(OneIsland, ACommandIsConfirmedOnlyByANewerReport) {
  const auto before = scheduler.wall_now();
  scheduler.run_for(1s);
  EXPECT_EQ(command("on"), tuples::Verdict::kApplied);
  ASSERT_EQ(devices_of(1).commands.size(), 1U);
  EXPECT_EQ(command_state()["state"], "sent");
  EXPECT_EQ(seen(kState), "") << "no optimistic echo";
  say(actuator("switch"), true, before);
  EXPECT_EQ(command_state()["state"], "sent") << "a report older than the command does not confirm it";
  say(actuator("switch"), true, scheduler.wall_now() + 1ms);
  EXPECT_EQ(command_state()["state"], "confirmed");
  EXPECT_EQ(seen(kState), "on");
}

TEST_F(OneIsland, ADeviceThatIgnoresACommandEndsItTimedOutWithTheOldValue) {
  say(actuator("switch"), false);
  EXPECT_EQ(command("on"), tuples::Verdict::kApplied);
  scheduler.run_for(6s);
  EXPECT_EQ(command_state()["state"], "timed-out");
  EXPECT_EQ(seen(kState), "off");
}

TEST_F(OneIsland, WrongCommandsAreRefusedInTheReply) {
  EXPECT_EQ(command("maybe"), tuples::Verdict::kRefused);
  EXPECT_TRUE(devices_of(1).commands.empty());
}

TEST_F(OneIsland, OfThreeCommandsToASleepingDeviceTheLastIsDeliveredWhenItWakes) {
  scheduler.run_for(61s);
  for (const auto* text : {"on", "off", "on"}) EXPECT_EQ(command(text), tuples::Verdict::kApplied);
  EXPECT_EQ(command_state()["state"], "queued");
  EXPECT_TRUE(devices_of(1).commands.empty());
  scheduler.run_for(4s);
  devices_of(1).say("7", model::KeepAlive{});
  scheduler.run_ready();
  ASSERT_EQ(devices_of(1).commands.size(), 1U);
  EXPECT_EQ(devices_of(1).commands[0].second, Value(true));
}

TEST_F(OneIsland, ALostLineIsSeenAtEverySensorAndHeals) {
  say(sensor("temperature"), 21.5);
  devices_of(1).lose_line();
  scheduler.run_ready();
  const auto status = json(component(70000), 1, "proxy.scripted-1.7.sensor.temperature-1.status");
  EXPECT_EQ(status["quality"], "network-down");
  EXPECT_EQ(json(component(70000), 1, "proxy.scripted-1.status")["reason"], "cable pulled");
  scheduler.run_for(5s);
  EXPECT_EQ(json(component(70000), 1, "proxy.scripted-1.status")["line"], "up");
  say(sensor("temperature"), 21.5);
  EXPECT_EQ(json(component(70000), 1, "proxy.scripted-1.7.sensor.temperature-1.status")["quality"], "good");
}

TEST_F(OneIsland, OfAThousandUpdatesASecondASlowSubscriberHearsOneAndTheLast) {
  std::vector<std::string> heard;
  const auto slow = component(70001).subscribe({OwnerId(1), kValue}, {.minimum = 1s, .maximum = 5s},
                                               [&](const Event& event) { heard.emplace_back(event.tuple.value); });
  scheduler.run_ready();
  heard.clear();
  for (int i = 1; i <= 10000; ++i) {
    say(sensor("temperature"), static_cast<double>(i) / 100);
    scheduler.run_for(1ms);
  }
  scheduler.run_for(1s);
  EXPECT_GE(heard.size(), 10U);
  EXPECT_LE(heard.size(), 12U);
  EXPECT_EQ(heard.back(), "100");
  heard.clear();
  scheduler.run_for(20s);
  EXPECT_EQ(heard, std::vector<std::string>(4, "100")) << "a constant value is heard each maximum interval";
}

}  // namespace
}  // namespace rubicon::scenarios
