#include "island.h"

namespace rubicon::proxy {
namespace {

class Changes : public Island {
 protected:
  void change() {
    proxy->reconfigure(config);
    time.run_ready();
  }
};

TEST_F(Changes, ARenamedDeviceKeepsValueQualityAndTimes) {
  start();
  join("7", lamp());
  const WallTime measured = time.wall_now() - 5s;
  report("7", sensor(kGlow), 12.5, measured);
  auto& names = rules().devices["7"];
  names.id = "kitchen";
  names.name = "Kitchen lamp";
  names.sensors["glow-1"] = "window";
  change();
  const std::string point = "proxy.hall.kitchen.sensor.glow-window";
  EXPECT_EQ(text(point + ".value"), "12.5");
  EXPECT_EQ(quality(point), "good");
  EXPECT_EQ(space->get(kIsland, point + ".value")->user_time, measured);
  EXPECT_EQ(json("proxy.hall.kitchen.description")["name"], "Kitchen lamp");
  EXPECT_EQ(json("proxy.hall.kitchen.status")["status"], "reachable");
  std::size_t old = 0;
  space->list({kIsland, "proxy.hall.7.**"}, [&](const tuples::TupleView&) { ++old; });
  EXPECT_EQ(old, 0U);
  report("7", sensor(kGlow), 14.0);
  EXPECT_EQ(text(point + ".value"), "14");
  time.run_for(1s);
  EXPECT_EQ(json("proxy.hall.devices"), (std::vector<std::string>{"kitchen"}));
}

TEST_F(Changes, OnlyTheRenamedDeviceIsTouched) {
  start();
  join("7", lamp());
  join("8", lamp());
  std::vector<std::string> touched;
  const auto watch = robot->subscribe({kIsland, "proxy.hall.8.**"}, {.passive = true},
                                      [&](const Event& event) { touched.emplace_back(event.tuple.key); });
  time.run_ready();
  touched.clear();
  rules().devices["7"].id = "kitchen";
  change();
  EXPECT_THAT(touched, testing::IsEmpty());
}

TEST_F(Changes, TwoDevicesSwapTheirIds) {
  rules().devices["7"].id = "left";
  rules().devices["8"].id = "right";
  start();
  join("7", lamp());
  join("8", lamp());
  report("7", sensor(kGlow), 7.0);
  report("8", sensor(kGlow), 8.0);
  rules().devices["7"].id = "right";
  rules().devices["8"].id = "left";
  change();
  EXPECT_EQ(text("proxy.hall.right.sensor.glow-1.value"), "7");
  EXPECT_EQ(text("proxy.hall.left.sensor.glow-1.value"), "8");
}

TEST_F(Changes, ADeviceIsConfiguredByTheNameItAnnouncesWhereNamesAreUnique) {
  rules().unique_names = true;
  rules().devices["Sofa"].id = "sofa";
  start();
  auto announced = lamp();
  announced.name = "Sofa";
  join("7", announced);
  report("7", sensor(kGlow), 7.0);
  EXPECT_EQ(text("proxy.hall.sofa.sensor.glow-1.value"), "7");
  announced.name = "Window";
  join("7", announced);
  report("7", sensor(kGlow), 8.0);
  EXPECT_EQ(text("proxy.hall.sofa.sensor.glow-1.value"), "8") << "a rename moves no key";
  announced.name = "Sofa";
  join("8", announced);
  report("8", sensor(kGlow), 1.0);
  EXPECT_EQ(text("proxy.hall.8.sensor.glow-1.value"), "1") << "the entry belongs to the first";
  rules().devices.clear();
  rules().devices["Window"].id = "window";
  change();
  EXPECT_EQ(text("proxy.hall.window.sensor.glow-1.value"), "8");
}

TEST_F(Changes, DemandFollowsTheNewKey) {
  start();
  join("7", lamp());
  const auto old_demand = robot->subscribe({kIsland, "proxy.hall.7.sensor.glow-1.value"}, {}, [](const Event&) {});
  time.run_ready();
  ASSERT_EQ(hall().sampled["7"].points.size(), 1U);
  rules().devices["7"].id = "kitchen";
  change();
  EXPECT_TRUE(hall().sampled["7"].points.empty());
  const auto request = robot->subscribe({kIsland, "proxy.hall.kitchen.sensor.glow-2.value"}, {}, [](const Event&) {});
  time.run_ready();
  EXPECT_EQ(hall().sampled["7"].points, (std::vector<PointId>{sensor(kGlow, "2")}));
}

TEST_F(Changes, AnActuatorThatIsSampledIsWantedAsSensorsAre) {
  start();
  auto message = lamp();
  for (auto& one : message.capabilities) one.sampled = one.point == actuator(kFlap);
  join("7", message);
  const auto ears = robot->subscribe({kIsland, "proxy.hall.7.actuator.**"}, {}, [](const Event&) {});
  time.run_ready();
  EXPECT_EQ(hall().sampled["7"].points, (std::vector<PointId>{actuator(kFlap)}));
}

TEST_F(Changes, ACommandUnderWayEndsUnderTheNewKey) {
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.hall.7.actuator.flap-1.command", "open").verdict, Verdict::kApplied);
  rules().devices["7"].id = "kitchen";
  change();
  report("7", actuator(kFlap), true);
  EXPECT_EQ(command_state("proxy.hall.kitchen.actuator.flap-1"), "confirmed");
}

TEST_F(Changes, AConfiguredIdTakesItsKeyFromTheDeviceThatHasIt) {
  start();
  join("7", lamp());
  join("8", lamp());
  rules().devices["7"].id = "8";
  change();
  EXPECT_EQ(json("proxy.hall.8.description")["address"], "7");
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  EXPECT_TRUE(log.contain("gave up its key"));
  EXPECT_EQ(json("proxy.inbox.hall.8")["address"], "8");
  rules().devices.clear();
  change();
  EXPECT_EQ(json("proxy.hall.7.description")["address"], "7");
  EXPECT_EQ(json("proxy.hall.8.description")["address"], "8");
  EXPECT_FALSE(exists("proxy.inbox.hall.8"));
}

TEST_F(Changes, NamesThatWouldMakeTwoPointsOneAreObjectedTo) {
  start();
  join("7", lamp());
  rules().devices["7"].sensors["glow-1"] = "2";
  rules().devices["8"].sensors["glow-1"] = "2";  // not there: nothing to say yet
  const auto objections = proxy->objections(config);
  ASSERT_EQ(objections.size(), 1U);
  EXPECT_EQ(objections[0].network, "hall");
  EXPECT_EQ(objections[0].address, "7");
  EXPECT_EQ(objections[0].text, "networks.hall.devices.7: glow-1 and glow-2 would both become glow-2");
}

TEST_F(Changes, ARemovedNetworkTakesItsTuplesAlong) {
  start();
  join("7", lamp());
  networks->remove("hall");
  gate->forget("hall");
  config.networks.erase("hall");
  change();
  std::size_t left = 0;
  space->list({kIsland, "proxy.hall.**"}, [&](const tuples::TupleView&) { ++left; });
  EXPECT_EQ(left, 0U);
  EXPECT_EQ(json("proxy.networks"), nlohmann::json::array());
}

TEST_F(Changes, AnAddedNetworkIsThereAtOnce) {
  start();
  config.networks["attic"].rate = 500ms;
  change();
  EXPECT_EQ(json("proxy.attic.status")["line"], "connecting");
  EXPECT_EQ(json("proxy.networks"), (std::vector<std::string>{"attic", "hall"}));
}

TEST_F(Changes, ShorterSilenceIsInForceAtOnce) {
  rules().silence = 1h;
  start();
  join("7", lamp());
  time.run_for(2min);
  rules().silence = 60s;
  change();
  time.run_for(1s);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "unreachable");
}

TEST_F(Changes, AnotherRateIsSampledAtOnce) {
  start();
  join("7", lamp());
  const auto request = robot->subscribe({kIsland, "proxy.hall.7.sensor.glow-1.value"}, {}, [](const Event&) {});
  time.run_ready();
  ASSERT_EQ(hall().sampled["7"].period, 1s);
  rules().rate = 200ms;
  change();
  EXPECT_EQ(hall().sampled["7"].period, 200ms);
}

TEST_F(Changes, NamesTakenAwayGiveTheDefaultsBack) {
  auto& names = rules().devices["7"];
  names.id = "kitchen";
  names.name = "Kitchen";
  names.sensors["glow-1"] = "window";
  start();
  join("7", lamp());
  rules().devices.clear();
  change();
  EXPECT_TRUE(exists("proxy.hall.7.sensor.glow-1.value"));
  EXPECT_EQ(json("proxy.hall.7.description")["name"], "Lamp");
}

}  // namespace
}  // namespace rubicon::proxy
