#include "island.h"

namespace rubicon::proxy {
namespace {

const std::string kDevice = "proxy.hall.7";

class Silence : public Island {
 protected:
  void begin() {
    start();
    join("7", lamp());
  }
  std::string status() const { return json(kDevice + ".status")["status"]; }
};

TEST_F(Silence, AQuietDeviceBecomesUnreachableAfterTheSilenceOfItsNetwork) {
  begin();
  report("7", sensor(kGlow), 1.5);
  time.run_for(59s);
  EXPECT_EQ(status(), "reachable");
  time.run_for(2s);
  EXPECT_EQ(status(), "unreachable");
  EXPECT_EQ(json(kDevice + ".status")["reason"], "silent for 60 s");
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "device-offline");
  EXPECT_EQ(text(kDevice + ".sensor.glow-1.value"), "1.5");
  EXPECT_EQ(text("proxy.hall.devices"), "[]");
}

TEST_F(Silence, AnyMessageKeepsADeviceReachable) {
  begin();
  for (int minute = 0; minute < 10; ++minute) {
    time.run_for(50s);
    say("7", model::KeepAlive{});
  }
  EXPECT_EQ(status(), "reachable");
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "unknown");
}

TEST_F(Silence, AKeepAliveBringsTheDeviceBackButNotItsValues) {
  begin();
  report("7", sensor(kGlow), 1.5);
  time.run_for(70s);
  say("7", model::KeepAlive{});
  time.run_for(300ms);
  EXPECT_EQ(status(), "reachable");
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "stale");
  EXPECT_EQ(json("proxy.hall.devices"), (std::vector<std::string>{"7"}));
  report("7", sensor(kGlow), 1.5);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "good");
}

TEST_F(Silence, AJoinBringsADeviceBack) {
  begin();
  time.run_for(70s);
  ASSERT_EQ(status(), "unreachable");
  join("7", lamp());
  EXPECT_EQ(status(), "reachable");
}

TEST_F(Silence, EachNetworkHasItsOwnSilence) {
  rules().silence = 5s;
  begin();
  time.run_for(6s);
  EXPECT_EQ(status(), "unreachable");
}

TEST_F(Silence, ComesAfterThousandsOfEarlierDeadlinesToo) {
  rules().silence = 24h;
  begin();
  join("8", lamp());
  report("8", sensor(kGlow), 1.5);
  for (int times = 0; times < 2000; ++times) {
    report("7", sensor(kGlow), 1.5);
    const auto watched = robot->subscribe({kIsland, kDevice + ".sensor.glow-1.value"}, {}, [](const Event&) {});
    time.run_for(4s);
  }
  ASSERT_EQ(status(), "reachable");
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "stale");
  report("7", sensor(kGlow), 1.5);
  time.run_for(24h - 1s);
  EXPECT_EQ(status(), "reachable");
  time.run_for(2s);
  EXPECT_EQ(status(), "unreachable");
  EXPECT_EQ(json("proxy.hall.8.status")["status"], "unreachable") << "whose deadline nothing moved";
}

TEST_F(Silence, NeverMeansThatTheLineDecides) {
  rules().silence = std::nullopt;
  begin();
  report("7", sensor(kGlow), 1.5);
  time.run_for(24h);
  EXPECT_EQ(status(), "reachable");
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "good");
  hall().lose_line();
  time.run_for(1s);
  EXPECT_EQ(status(), "unreachable");
  hall().line_works = true;
  time.run_for(5s);
  EXPECT_EQ(status(), "reachable");
}

TEST_F(Silence, ADeviceKnownByConfigurationOnlyIsUnknownUntilHeard) {
  start();
  auto message = lamp();
  message.heard = false;
  join("7", message);
  EXPECT_EQ(status(), "unknown");
  time.run_for(10min);
  EXPECT_EQ(status(), "unknown");
  report("7", sensor(kGlow), 1.5);
  EXPECT_EQ(status(), "reachable");
  time.run_for(61s);
  EXPECT_EQ(status(), "unreachable");
}

TEST_F(Silence, ManyReadingsLeaveOneTimer) {
  begin();
  for (int i = 0; i < 1000; ++i) {
    report("7", sensor(kGlow), 1.5);
    time.run_for(59ms);
  }
  EXPECT_EQ(status(), "reachable");
  time.run_for(61s);
  EXPECT_EQ(status(), "unreachable");
}

TEST_F(Silence, ASensorOlderThanItsDeadlineIsStaleWhileItsDeviceLives) {
  start();
  auto message = lamp();
  message.capabilities[0].deadline = 10s;
  message.capabilities[1].deadline = 0s;
  join("7", message);
  report("7", sensor(kGlow, "1"), 1.5);
  report("7", sensor(kGlow, "2"), 2.5);
  for (int i = 0; i < 11; ++i) {
    time.run_for(1s);
    say("7", model::KeepAlive{});
  }
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "stale");
  EXPECT_EQ(quality(kDevice + ".sensor.glow-2"), "good");
  EXPECT_EQ(json(kDevice + ".sensor.glow-1.status")["reason"], "not heard for 10 s");
  report("7", sensor(kGlow, "1"), 1.5);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "good");
}

TEST_F(Silence, ASampledSensorIsStaleAfterThreePeriods) {
  begin();
  const auto ears = space->subscribe({kIsland, kDevice + ".sensor.glow-1.value"}, {.minimum = 2s}, [](const Event&) {});
  time.run_ready();
  report("7", sensor(kGlow), 1.5);
  time.run_for(5900ms);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "good");
  time.run_for(200ms);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "stale");
}

TEST_F(Silence, AFastSampledSensorHasThreeSeconds) {
  begin();
  const auto ears =
      space->subscribe({kIsland, kDevice + ".sensor.glow-1.value"}, {.minimum = 10ms}, [](const Event&) {});
  time.run_ready();
  report("7", sensor(kGlow), 1.5);
  time.run_for(2900ms);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "good");
  time.run_for(200ms);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "stale");
}

TEST_F(Silence, AFurtherSubscriberGivesASilentSensorNoNewFirstPeriod) {
  begin();
  const auto first =
      space->subscribe({kIsland, kDevice + ".sensor.glow-1.value"}, {.minimum = 1s}, [](const Event&) {});
  time.run_ready();
  report("7", sensor(kGlow), 1.5);
  time.run_for(2s);
  const auto second = space->subscribe({kIsland, kDevice + ".sensor.glow-1.value"}, {}, [](const Event&) {});
  time.run_for(1100ms);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "stale");
}

TEST_F(Silence, AnOldValueIsNotStaleTheMomentItIsSubscribedTo) {
  begin();
  report("7", sensor(kGlow), 1.5);
  time.run_for(30s);
  const auto ears = space->subscribe({kIsland, kDevice + ".sensor.glow-1.value"}, {}, [](const Event&) {});
  time.run_for(2s);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "good");
  time.run_for(1100ms);
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "stale");
}

TEST_F(Silence, ADeadSensorDoesNotLiveOnSubscriptions) {
  begin();
  report("7", sensor(kGlow), 1.5);
  for (int i = 0; i < 31; ++i) {
    const auto ears = space->subscribe({kIsland, kDevice + ".sensor.glow-1.value"}, {}, [](const Event&) {});
    time.run_for(2s);
    say("7", model::KeepAlive{});
  }
  EXPECT_EQ(quality(kDevice + ".sensor.glow-1"), "stale");
}

TEST_F(Silence, AnActuatorThatReportsChangesOnlyStaysGood) {
  begin();
  report("7", actuator(kFlap), true);
  for (int i = 0; i < 20; ++i) {
    time.run_for(30s);
    say("7", model::KeepAlive{});
  }
  EXPECT_EQ(quality(kDevice + ".actuator.flap-1"), "good");
}

TEST_F(Silence, AnActuatorOutOfReachIsStaleWhenItsDeviceReturns) {
  begin();
  report("7", actuator(kFlap), true);
  time.run_for(70s);
  EXPECT_EQ(quality(kDevice + ".actuator.flap-1"), "device-offline");
  say("7", model::KeepAlive{});
  EXPECT_EQ(quality(kDevice + ".actuator.flap-1"), "stale");
}

TEST_F(Silence, ThousandsOfDevicesFallSilentAtOnce) {
  start();
  for (int device = 0; device < 3000; ++device) hall().say(std::to_string(device), lamp());
  time.run_for(61s);
  int lost = 0;
  space->list({kIsland, "proxy.hall.*.status"}, [&](const tuples::TupleView& tuple) {
    if (tuple.value.find("unreachable") != tuple.value.npos) ++lost;
  });
  EXPECT_EQ(lost, 3000);
}

class Probing : public Island {
 protected:
  void SetUp() override {
    remember();
    rules().probes = true;
  }
  std::size_t probes() { return hall().sent_bodies<model::Probe>().size(); }
};

TEST_F(Probing, ADeviceThatSpeaksIsNotAsked) {
  start();
  join("7", lamp());
  for (int i = 0; i < 20; ++i) {
    time.run_for(25s);
    say("7", model::KeepAlive{});
  }
  EXPECT_EQ(probes(), 0u);
}

TEST_F(Probing, ADeviceSilentForHalfTheSilenceIsAskedAndStaysReachableIfItAnswers) {
  start();
  join("7", lamp());
  time.run_for(29s);
  EXPECT_EQ(probes(), 0u);
  time.run_for(2s);
  ASSERT_EQ(probes(), 1u);
  EXPECT_EQ(hall().sent.back().destination.device, "7");
  say("7", model::KeepAlive{});
  time.run_for(29s);
  EXPECT_EQ(probes(), 1u);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable");
}

TEST_F(Probing, ADeviceThatMissesOneQuestionIsAskedOnceMoreBeforeItIsUnreachable) {
  start();
  join("7", lamp());
  time.run_for(31s);
  ASSERT_EQ(probes(), 1u);
  time.run_for(15s);
  ASSERT_EQ(probes(), 2u);
  say("7", model::KeepAlive{});
  time.run_for(29s);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable");
  EXPECT_EQ(probes(), 2u);
}

TEST_F(Probing, AnUnreachableDeviceIsAskedEachHalfSilenceForEver) {
  start();
  join("7", lamp());
  time.run_for(1min + 1s);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "unreachable");
  const auto before = probes();
  time.run_for(9min);
  EXPECT_EQ(probes(), before + 18);
}

TEST_F(Probing, ARememberedDeviceIsAskedAtOnceWithWhatIsRememberedOfIt) {
  start();
  join("7", lamp());
  time.run_for(2s);
  restart();
  time.run_ready();
  const auto asked = hall().sent_bodies<model::Probe>();
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_EQ(asked[0].known.model, lamp().model);
  EXPECT_EQ(asked[0].known.capabilities.size(), lamp().capabilities.size());
}

TEST_F(Probing, DevicesAreNotProbedWhileTheLineIsDownAndAtOnceAfterwards) {
  start();
  join("7", lamp());
  hall().line_works = false;
  hall().lose_line();
  time.run_for(5min);
  EXPECT_EQ(probes(), 0u);
  hall().line_works = true;
  time.run_for(2s);
  EXPECT_EQ(probes(), 1u);
}

TEST_F(Probing, WithoutAnEndOfSilenceOnlyTheRememberedAreAskedOnce) {
  rules().silence.reset();
  start();
  join("7", lamp());
  time.run_for(1h);
  EXPECT_EQ(probes(), 0u);
  restart();
  time.run_for(1h);
  EXPECT_EQ(probes(), 1u);
}

TEST_F(Silence, NetworksThatCannotProbeAreNotAskedTo) {
  begin();
  time.run_for(5min);
  EXPECT_TRUE(hall().sent_bodies<model::Probe>().empty());
}

}  // namespace
}  // namespace rubicon::proxy
