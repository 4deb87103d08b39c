#include "scenarios/motes.h"

namespace rubicon::scenarios {
namespace {

using testing::Each;
using testing::Ge;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// --- Restarts.

TEST_F(Motes, ARestartUnderTrafficNeedsNoReboot) {
  const auto file = state_file();
  begin_world(4, em1000());
  start(1, network("wsn-1", 1), file);
  scheduler.run_for(6s);
  const auto light = want(1, "wsn-1.2.sensor.light-1");
  const auto temperature = want(1, "wsn-1.3.sensor.temperature-1");
  scheduler.run_for(30s);
  const auto before = seen_json(1, "proxy.wsn-1.2.description");
  const auto last = seen(1, "proxy.wsn-1.2.sensor.light-1.value");
  ASSERT_NE(last, "");
  islands.erase(1);
  scheduler.run_for(5s);
  happened.clear();
  start(1, network("wsn-1", 1), file);
  for (const auto* mote : {"wsn-1.2", "wsn-1.3", "wsn-1.4", "wsn-1.5"}) EXPECT_EQ(status(1, mote), "unknown") << mote;
  EXPECT_EQ(seen(1, "proxy.wsn-1.2.sensor.light-1.value"), last);
  EXPECT_EQ(seen_json(1, "proxy.wsn-1.2.sensor.light-1.status")["quality"], "stored");
  scheduler.run_for(5s);
  for (const auto* mote : {"wsn-1.2", "wsn-1.3", "wsn-1.4", "wsn-1.5"}) EXPECT_TRUE(reachable(1, mote)) << mote;
  EXPECT_EQ(seen_json(1, "proxy.wsn-1.2.description"), before) << "it declared more than it reports";
  EXPECT_EQ(seen_json(1, "proxy.wsn-1.2.sensor.light-1.status")["quality"], "good");
  EXPECT_NE(seen(1, "proxy.wsn-1.2.sensor.light-1.value"), last);
  EXPECT_EQ(events("boot") + events("listed"), 0U);
  const auto humidity = want(1, "wsn-1.5.sensor.humidity-1");
  scheduler.run_for(2s);
  EXPECT_EQ(seen(1, "proxy.wsn-1.5.property.mask.value"), "64") << "and can be asked for all of it";
}

TEST_F(Motes, ManyRestartsUnderTrafficLoseNoMote) {
  const auto file = state_file();
  begin_world(5, em1000());
  start(1, network("wsn-1", 1), file);
  scheduler.run_for(10s);
  world->radio().options().loss = 0.02;
  std::vector<Handle> requests;
  for (int mote = 2; mote <= 6; ++mote)
    requests.push_back(want(1, "wsn-1." + std::to_string(mote) + ".sensor.light-1"));
  scheduler.run_for(5s);
  happened.clear();
  for (int round = 0; round < 100; ++round) {
    islands.erase(1);
    scheduler.run_for(std::chrono::milliseconds(137 * (round % 20)));
    start(1, network("wsn-1", 1), file);
    scheduler.run_for(10s);
    for (int mote = 2; mote <= 6; ++mote)
      ASSERT_TRUE(reachable(1, "wsn-1." + std::to_string(mote))) << mote << " after restart " << round;
  }
  EXPECT_EQ(events("boot"), 0U);
}

// --- The line and the radio. Two motes of five are wanted.

class TroubledMotes : public Motes {
 protected:
  void SetUp() override {
    begin_world(5, em1000());
    start(1, network("wsn-1", 1));
    scheduler.run_for(5s);
    demands_.push_back(want(1, "wsn-1.2.sensor.light-1"));
    demands_.push_back(want(1, "wsn-1.3.sensor.temperature-1"));
    scheduler.run_for(5s);
    light_ = hear(1, "wsn-1.2.sensor.light-1");
    temperature_ = hear(1, "wsn-1.3.sensor.temperature-1");
  }
  /// Values that came in a span from now on.
  std::pair<std::size_t, std::size_t> flow(Duration span) {
    light_->values.clear();
    temperature_->values.clear();
    scheduler.run_for(span);
    return {light_->values.size(), temperature_->values.size()};
  }
  void expect_nothing_grew() {
    scheduler.run_for(5s);
    for (const auto* name : {"waiting-command", "waiting-client", "waiting-sampling", "waiting-probe", "waiting-probes",
                             "pending-messages"})
      EXPECT_EQ(counter(1, "wsn-1", name), 0U) << name;
  }

 private:
  std::vector<Handle> demands_;
  std::unique_ptr<Heard> light_, temperature_;
};

TEST_F(TroubledMotes, ASinkThatWasSwitchedOffAndOnIsHeardAgainByItself) {
  world->sink(1).reboot();
  EXPECT_THAT(flow(1s).first, 0U) << "it is on another island";
  scheduler.run_for(6s);  // what is stale after three seconds is missed
  const auto [light, temperature] = flow(20s);
  EXPECT_GE(light, 18U);
  EXPECT_GE(temperature, 18U);
  expect_nothing_grew();
}

TEST_F(TroubledMotes, TheMotesOfASinkThatWasSwitchedOffAndOnStayReachable) {
  for (int round = 0; round < 5; ++round) {
    world->sink(1).reboot();
    for (int i = 0; i < 40; ++i) {
      scheduler.run_for(1s);
      for (int mote = 2; mote <= 6; ++mote)
        ASSERT_TRUE(reachable(1, "wsn-1." + std::to_string(mote))) << mote << " after " << i << " s";
    }
  }
}

TEST_F(TroubledMotes, ASinkThatWasUnpluggedForHalfAMinuteIsHeardAgainByItself) {
  world->unplug(1, 30s);
  scheduler.run_for(10s);
  EXPECT_NE(seen(1, "proxy.wsn-1.property.line.value"), "up");
  EXPECT_THAT(seen_json(1, "proxy.wsn-1.2.sensor.light-1.status")["quality"], testing::AnyOf("network-down", "stale"));
  scheduler.run_for(25s);
  const auto [light, temperature] = flow(20s);
  EXPECT_GE(light, 18U);
  EXPECT_GE(temperature, 18U);
  EXPECT_EQ(seen(1, "proxy.wsn-1.property.line.value"), "up");
  for (int mote = 2; mote <= 6; ++mote) EXPECT_TRUE(reachable(1, "wsn-1." + std::to_string(mote))) << mote;
  expect_nothing_grew();
}

TEST_F(TroubledMotes, ARadioThatLosesAFifthLosesAFifthOfTheValuesAndNoMote) {
  world->radio().options().loss = 0.2;
  for (auto* mote : world->motes({})) {
    do {  // seven requests may all be lost
      mote->boot();
      scheduler.run_for(4s);
    } while (!mote->joined());
  }
  scheduler.run_for(10s);
  const auto [light, temperature] = flow(100s);
  EXPECT_GE(light, 65U);
  EXPECT_GE(temperature, 65U);
  for (int i = 0; i < 10; ++i) {
    scheduler.run_for(30s);
    for (int mote = 2; mote <= 6; ++mote) EXPECT_TRUE(reachable(1, "wsn-1." + std::to_string(mote))) << mote;
  }
  world->radio().options().loss = 0;
  expect_nothing_grew();
}

TEST_F(TroubledMotes, ARadioThatCarriesAllTwiceDoesNoHarm) {
  world->radio().options().duplicates = 1;
  const auto values = hear(1, "wsn-1.2.sensor.light-1");
  scheduler.run_for(20s);
  EXPECT_THAT(values->values, SizeIs(testing::AllOf(Ge(18), testing::Le(21)))) << "one measurement is one value";
  EXPECT_TRUE(std::is_sorted(values->values.begin(), values->values.end(), [](const auto& a, const auto& b) {
    return std::stod(a) < std::stod(b);
  })) << "an old value never follows a newer one";
  world->mote(2).boot();
  scheduler.run_for(3s);
  EXPECT_GE(flow(10s).first, 8U);
  expect_nothing_grew();
}

TEST_F(TroubledMotes, AMoteThatIsRebootedReportsAgainByItself) {
  world->mote(2).boot();
  scheduler.run_for(3s);
  EXPECT_GE(flow(20s).first, 18U);
}

TEST_F(Motes, MotesThatAreRebootedUnheardGetTheirCommandAgain) {
  begin_world(8, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(8s);
  std::vector<Handle> requests;
  std::map<std::uint16_t, std::unique_ptr<Heard>> heard;
  for (std::uint16_t mote = 2; mote <= 9; ++mote) {
    const auto sensor = "wsn-1." + std::to_string(mote) + ".sensor.light-1";
    requests.push_back(want(1, sensor));
    heard[mote] = hear(1, sensor);
  }
  scheduler.run_for(10s);
  happened.clear();
  for (auto* mote : world->motes({})) mote->boot();
  scheduler.run_for(4s);
  int unheard = 0;
  for (auto* mote : world->motes({})) {
    ASSERT_TRUE(mote->joined());
    unheard += events("listed", mote->address()) == 0;
  }
  ASSERT_GT(unheard, 0) << "else this test shows nothing";
  scheduler.run_for(11s);
  for (auto& [mote, values] : heard) values->values.clear();
  scheduler.run_for(10s);
  for (const auto& [mote, values] : heard) EXPECT_THAT(values->values, SizeIs(Ge(8))) << mote;
}

// --- Commands.

constexpr const char* kLed = "wsn-1.2.actuator.led-1";

TEST_F(Motes, TheReleasedFirmwareTakesACommandAndDoesNothing) {
  begin_world(1, em1000());
  start(1, network("wsn-1", 1));
  scheduler.run_for(5s);
  EXPECT_EQ(command(1, kLed, "1").verdict, tuples::Verdict::kApplied);
  scheduler.run_for(1s);
  EXPECT_EQ(command_state(1, kLed), "sent");
  EXPECT_EQ(events("ignored", 2), 1U);
  scheduler.run_for(30s);
  EXPECT_EQ(command_state(1, kLed), "timed-out");
  EXPECT_EQ(seen(1, std::string("proxy.") + kLed + ".value"), "");
}

TEST_F(Motes, MotesThatObeyWithoutReportingAreAssumedToHaveObeyed) {
  begin_world(2, em1000(true));
  start(1, network("wsn-1", 1, "actuators: assumed"));
  scheduler.run_for(5s);
  EXPECT_EQ(command(1, kLed, "1").verdict, tuples::Verdict::kApplied);
  scheduler.run_for(2s);
  EXPECT_EQ(command_state(1, kLed), "assumed");
  EXPECT_EQ(seen(1, std::string("proxy.") + kLed + ".value"), "1");
  EXPECT_EQ(seen_json(1, std::string("proxy.") + kLed + ".status")["quality"], "assumed");
  EXPECT_EQ(events("actuator", 3), 0U);
  ASSERT_EQ(events("actuator", 2), 1U);
  const auto switched =
      std::find_if(happened.begin(), happened.end(), [](const auto& event) { return event.what == "actuator"; });
  EXPECT_EQ(switched->value, 1);
}

TEST_F(Motes, ACommandToAMoteThatIsGoneFails) {
  begin_world(1, em1000(true));
  start(1, network("wsn-1", 1, "actuators: assumed"));
  scheduler.run_for(5s);
  world->mote(2).kill();
  EXPECT_EQ(command(1, kLed, "1").verdict, tuples::Verdict::kApplied);
  scheduler.run_for(10s);
  EXPECT_EQ(command_state(1, kLed), "failed");
  EXPECT_THAT(seen(1, std::string("proxy.") + kLed + ".status"), HasSubstr("unknown"));
}

TEST_F(Motes, ACommandGetsThroughABadRadio) {
  begin_world(1, em1000(true));
  start(1, network("wsn-1", 1, "actuators: assumed"));
  scheduler.run_for(5s);
  world->radio().options().loss = 0.2;
  int assumed = 0;
  for (int i = 1; i <= 50; ++i) {
    const auto switched = events("actuator", 2);
    ASSERT_EQ(command(1, kLed, std::to_string(i % 2)).verdict, tuples::Verdict::kApplied);
    scheduler.run_for(10s);
    const auto state = command_state(1, kLed);
    assumed += state == "assumed";
    EXPECT_TRUE(state != "assumed" || events("actuator", 2) > switched) << i;
  }
  EXPECT_GE(assumed, 45) << "0.64 of the attempts succeed, and there are three";
}

TEST_F(Motes, ACommandWhoseTimeIsOverIsNotExecutedWhenTheSinkComesBack) {
  begin_world(1, em1000(true));
  start(1, network("wsn-1", 1, "actuators: assumed"));
  scheduler.run_for(5s);
  world->unplug(1, 60s);
  scheduler.run_for(1s);
  EXPECT_EQ(command(1, kLed, "1", 5s).verdict, tuples::Verdict::kApplied);
  scheduler.run_for(3s);
  EXPECT_EQ(command_state(1, kLed), "queued");
  scheduler.run_for(3s);
  EXPECT_EQ(command_state(1, kLed), "expired");
  scheduler.run_for(120s);
  EXPECT_TRUE(reachable(1, "wsn-1.2"));
  EXPECT_EQ(events("actuator"), 0U);
  EXPECT_EQ(command_state(1, kLed), "expired");
}

TEST_F(Motes, ACommandWithTimeLeftIsExecutedWhenTheSinkComesBack) {
  begin_world(1, em1000(true));
  start(1, network("wsn-1", 1, "actuators: assumed"));
  scheduler.run_for(5s);
  world->unplug(1, 10s);
  scheduler.run_for(1s);
  EXPECT_EQ(command(1, kLed, "1", 60s).verdict, tuples::Verdict::kApplied);
  scheduler.run_for(20s);
  EXPECT_EQ(command_state(1, kLed), "assumed");
  EXPECT_EQ(events("actuator"), 1U);
}

// --- Roaming.

TEST_F(Motes, AMoteThatIsCarriedToAnotherIslandIsListedThereAndGoneHere) {
  setup.sinks = 2;
  setup.add_motes(1, 2, 2, em1000());
  setup.add_motes(2, 9, 1, em1000());
  begin_world();
  start(1, network("wsn-1", 1, "roaming: lab"));
  start(2, network("wsn-1", 2, "roaming: lab"));
  scheduler.run_for(6s);
  ASSERT_TRUE(reachable(1, "wsn-1.2"));
  ASSERT_EQ(status(2, "wsn-1.2"), nlohmann::json());
  auto subscription =
      component(kRobot).subscribe({std::nullopt, "proxy.*.2.sensor.light-1.value"}, {}, [](const Event&) {});
  scheduler.run_for(5s);
  world->mote(2).move_to({2});
  world->mote(2).boot();
  scheduler.run_for(5s);
  EXPECT_TRUE(reachable(2, "wsn-1.2"));
  EXPECT_EQ(status(1, "wsn-1.2"), nlohmann::json()) << "gone";
  EXPECT_TRUE(reachable(1, "wsn-1.3"));
  const auto there = hear(2, "wsn-1.2.sensor.light-1");
  scheduler.run_for(10s);
  EXPECT_THAT(there->values, SizeIs(Ge(8))) << "a subscription to any island receives it";
  world->mote(2).move_to({1});
  world->mote(2).boot();
  scheduler.run_for(5s);
  EXPECT_TRUE(reachable(1, "wsn-1.2"));
  EXPECT_EQ(status(2, "wsn-1.2"), nlohmann::json());
}

}  // namespace
}  // namespace rubicon::scenarios
