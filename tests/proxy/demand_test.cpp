#include <algorithm>
#include <random>

#include "island.h"

namespace rubicon::proxy {
namespace {

using Sampled = std::vector<PointId>;

class DemandOfSubscribers : public Island {
 protected:
  void begin() {
    start();
    join("7", lamp());
  }
  tuples::Handle listen(TupleSpace& who, const std::string& pattern, Flow flow = {}) {
    auto handle = who.subscribe({std::nullopt, pattern}, flow, [](const Event&) {});
    time.run_ready();
    return handle;
  }
  const model::Sample& sample(const std::string& device = "7") { return hall().sampled[device]; }
  std::size_t samples() { return hall().sent_bodies<model::Sample>().size(); }
  static constexpr auto kGlow1 = "proxy.hall.7.sensor.glow-1.value";
  static constexpr auto kGlow2 = "proxy.hall.7.sensor.glow-2.value";
};

TEST_F(DemandOfSubscribers, WithoutSubscribersNothingIsSampled) {
  begin();
  time.run_for(10s);
  EXPECT_EQ(samples(), 0u);
}

TEST_F(DemandOfSubscribers, TheFirstSubscriberStartsAndTheLastOneStopsSampling) {
  begin();
  auto first = listen(*robot, kGlow1);
  EXPECT_EQ(sample().points, Sampled{sensor(kGlow)});
  EXPECT_EQ(sample().period, 1000ms);
  auto second = listen(*space, kGlow1);
  EXPECT_EQ(samples(), 1u);
  first.reset();
  time.run_ready();
  EXPECT_EQ(samples(), 1u);
  second.reset();
  time.run_ready();
  EXPECT_EQ(samples(), 2u);
  EXPECT_TRUE(sample().points.empty());
}

TEST_F(DemandOfSubscribers, AnActuatorIsSampledOnlyIfItDeclaresSo) {
  start();
  auto message = lamp();
  join("7", message);
  auto ears = listen(*robot, "proxy.hall.7.actuator.flap-1.value");
  EXPECT_EQ(samples(), 0u);
  message.capabilities.back().sampled = true;
  join("8", message);
  auto more = listen(*robot, "proxy.hall.8.actuator.flap-1.value");
  EXPECT_EQ(sample("8").points, Sampled{actuator(kFlap)});
}

TEST_F(DemandOfSubscribers, PassiveSubscribersCreateNone) {
  begin();
  auto dashboard = listen(*robot, "proxy.**", {.passive = true});
  EXPECT_EQ(samples(), 0u);
}

TEST_F(DemandOfSubscribers, SensorsOfADeviceAreMergedIntoOneRequestWithTheShortestPeriod) {
  begin();
  auto one = robot->subscribe({std::nullopt, kGlow1}, {.minimum = 500ms}, [](const Event&) {});
  auto two = robot->subscribe({std::nullopt, kGlow2}, {.minimum = 200ms}, [](const Event&) {});
  time.run_ready();
  EXPECT_EQ(samples(), 1u);
  EXPECT_EQ(sample().points, (Sampled{sensor(kGlow, "1"), sensor(kGlow, "2")}));
  EXPECT_EQ(sample().period, 200ms);
  two.reset();
  time.run_ready();
  EXPECT_EQ(sample().points, Sampled{sensor(kGlow)});
  EXPECT_EQ(sample().period, 500ms);
}

TEST_F(DemandOfSubscribers, ASubscriberThatNamesNoPeriodGetsTheRateOfTheNetwork) {
  rules().rate = 250ms;
  begin();
  auto ears = listen(*robot, kGlow1);
  EXPECT_EQ(sample().period, 250ms);
}

TEST_F(DemandOfSubscribers, AWaitingSubscriptionSamplesADeviceThatJoinsLater) {
  start();
  auto ears = listen(*robot, "proxy.**");
  join("7", lamp());
  EXPECT_EQ(sample().points, (Sampled{sensor(kGlow, "1"), sensor(kGlow, "2")}));
}

TEST_F(DemandOfSubscribers, ActuatorsAreNotSampled) {
  begin();
  auto ears = listen(*robot, "proxy.hall.7.actuator.**");
  EXPECT_EQ(samples(), 0u);
}

TEST_F(DemandOfSubscribers, ARejoinRepeatsTheRequest) {
  begin();
  auto ears = listen(*robot, kGlow1);
  join("7", lamp());
  EXPECT_EQ(samples(), 2u);
  EXPECT_EQ(sample().points, Sampled{sensor(kGlow)});
}

TEST_F(DemandOfSubscribers, ARejoinWithoutASensorSamplesTheOthers) {
  begin();
  auto ears = listen(*robot, "proxy.hall.7.sensor.*.value");
  auto changed = lamp();
  changed.capabilities.erase(changed.capabilities.begin());
  join("7", changed);
  EXPECT_EQ(sample().points, Sampled{sensor(kGlow, "2")});
}

TEST_F(DemandOfSubscribers, ADeviceThatReturnsGetsItsOrderAgain) {
  begin();
  auto ears = listen(*robot, kGlow1);
  time.run_for(61s);
  EXPECT_EQ(samples(), 1u);
  say("7", model::KeepAlive{});
  EXPECT_EQ(samples(), 2u);
}

TEST_F(DemandOfSubscribers, AnUnsampledDeviceThatReturnsIsLeftInPeace) {
  begin();
  time.run_for(61s);
  say("7", model::KeepAlive{});
  join("7", lamp());
  EXPECT_EQ(samples(), 0u);
}

TEST_F(DemandOfSubscribers, WhatChangedWhileTheLineWasDownIsSentWhenItIsUp) {
  begin();
  hall().lose_line();
  time.run_for(10ms);
  auto ears = listen(*robot, kGlow1);
  EXPECT_EQ(samples(), 0u);
  hall().line_works = true;
  time.run_for(5s);
  EXPECT_EQ(samples(), 1u);
  EXPECT_EQ(sample().points, Sampled{sensor(kGlow)});
}

TEST_F(DemandOfSubscribers, ALineThatIsUpAgainRepeatsTheOrder) {
  begin();
  auto ears = listen(*robot, kGlow1);
  hall().lose_line();
  time.run_for(10ms);
  hall().line_works = true;
  time.run_for(5s);
  EXPECT_EQ(samples(), 2u);
}

TEST_F(DemandOfSubscribers, ARefusedRequestIsShownAtTheSensor) {
  begin();
  hall().outcome = Outcome::kUnsupported;
  hall().why = "reports on change only";
  auto ears = listen(*robot, kGlow1);
  EXPECT_EQ(json("proxy.hall.7.sensor.glow-1.status")["reason"], "sampling unsupported: reports on change only");
  report("7", sensor(kGlow), 1.5);
  time.run_for(50s);
  EXPECT_EQ(quality("proxy.hall.7.sensor.glow-1"), "good") << "three periods mean nothing where nobody samples";
}

TEST_F(DemandOfSubscribers, ALateAnswerToAFormerRequestCountsNoMore) {
  begin();
  hall().answers = false;
  auto slow = listen(*robot, kGlow1, {.minimum = 1s});
  auto fast = listen(*robot, kGlow1, {.minimum = 200ms});
  const auto asked = hall().sent_bodies<model::Sample>();
  ASSERT_EQ(asked.size(), 2u);
  say("7", Acknowledge{asked[1].request, Outcome::kSent, {}});
  say("7", Acknowledge{asked[0].request, Outcome::kFailed, "no answer"});
  EXPECT_EQ(json("proxy.hall.7.sensor.glow-1.status")["reason"], "");
}

TEST_F(DemandOfSubscribers, ABusyNetworkIsAskedAgain) {
  begin();
  hall().outcome = Outcome::kBusy;
  auto ears = listen(*robot, kGlow1);
  time.run_for(500ms);
  hall().outcome = Outcome::kSent;
  time.run_for(2s);
  EXPECT_EQ(samples(), 2u);
  EXPECT_EQ(sample().points, Sampled{sensor(kGlow)});
}

TEST_F(DemandOfSubscribers, AStopThatFailedIsRepeatedWhenTheDeviceReturns) {
  begin();
  auto ears = listen(*robot, kGlow1);
  hall().outcome = Outcome::kFailed;
  ears.reset();
  time.run_for(61s);
  hall().outcome = Outcome::kSent;
  say("7", model::KeepAlive{});
  EXPECT_TRUE(hall().sampled["7"].points.empty());
  EXPECT_EQ(samples(), 3u);
}

TEST_F(DemandOfSubscribers, TenThousandRandomSubscriptionsEndInTheUnionOfTheLiveOnes) {
  constexpr int kDevices = 20;
  start();
  auto second_link = *ecology.join(OwnerId{70002});
  TupleSpace second(OwnerId{70002}, time, *second_link);
  for (int device = 0; device < kDevices; ++device) join(std::to_string(device), lamp());
  struct Live {
    int device, glow, period;
    tuples::Handle handle;
  };
  std::vector<Live> live;
  std::mt19937 dice(20130301);
  TupleSpace* const components[] = {space.get(), robot.get(), &second};
  for (int step = 0; step < 10000; ++step) {
    if (!live.empty() && dice() % 2 == 0) {
      live.erase(live.begin() + static_cast<std::ptrdiff_t>(dice() % live.size()));
    } else {
      const int device = static_cast<int>(dice() % kDevices), glow = 1 + static_cast<int>(dice() % 2);
      const int period = 100 * static_cast<int>(1 + dice() % 9);
      const auto key = "proxy.hall." + std::to_string(device) + ".sensor.glow-" + std::to_string(glow) + ".value";
      live.push_back(
          {device, glow, period,
           components[dice() % 3]->subscribe({std::nullopt, key}, {.minimum = period * 1ms}, [](const Event&) {})});
    }
    if (dice() % 4 == 0) time.run_ready();
  }
  time.run_ready();
  for (int device = 0; device < kDevices; ++device) {
    Sampled expected;
    int shortest = 0;
    for (const int glow : {1, 2}) {
      for (const auto& one : live) {
        if (one.device != device || one.glow != glow) continue;
        shortest = shortest == 0 ? one.period : std::min(shortest, one.period);
        const auto point = sensor(kGlow, std::to_string(glow));
        if (std::find(expected.begin(), expected.end(), point) == expected.end()) expected.push_back(point);
      }
    }
    EXPECT_EQ(sample(std::to_string(device)).points, expected) << "device " << device;
    EXPECT_EQ(sample(std::to_string(device)).period, shortest * 1ms) << "device " << device;
  }
}

TEST_F(DemandOfSubscribers, ASensorThatIsWantedButSilentIsAskedForAgainUntilItReports) {
  start();
  join("7", lamp());
  const auto request =
      robot->subscribe({kIsland, "proxy.hall.7.sensor.glow-1.value"}, {.minimum = 1s}, [](const Event&) {});
  time.run_ready();
  report("7", sensor(kGlow), 1.0);
  hall().sent.clear();
  hall().answers = false;  // from now on requests get lost, though the device lives
  const auto live = [this](int seconds) {
    for (int i = 0; i < seconds; ++i) {
      say("7", model::KeepAlive{});
      time.run_for(1s);
    }
    return hall().sent_bodies<model::Sample>().size();
  };
  EXPECT_EQ(live(5), 1U) << "told again when the value became stale";
  EXPECT_EQ(live(20), 3U);
  report("7", sensor(kGlow), 2.0);
  EXPECT_EQ(live(2), 3U);
}

}  // namespace
}  // namespace rubicon::proxy
