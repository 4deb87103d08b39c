#include "apps/simulators/zigbee/world.h"

#include "simulators/zigbee/simulated_bridge.h"

namespace rubicon::zigbee_simulator {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST_F(SimulatedBridge, StartsAsARealOne) {
  make();
  add("lamp", "kitchen/lamp");
  world->start();
  EXPECT_THAT(topics(), ElementsAre("bridge/state", "bridge/converters", "bridge/info", "bridge/devices",
                                    "bridge/groups", "bridge/extensions", "kitchen/lamp/availability", "kitchen/lamp"));
  EXPECT_EQ(of("bridge/info")[0]["version"], "2.14.1");
  EXPECT_THAT(of("bridge/devices")[0], SizeIs(2));
  EXPECT_EQ(of("kitchen/lamp")[0]["last_seen"], "2025-12-31T23:00:00.000Z") << "an hour old: a start-up copy";
  for (const auto& one : published) EXPECT_EQ(one.retain, one.topic != "kitchen/lamp") << one.topic;
}

TEST_F(SimulatedBridge, EachModelOfTheListCanBeAdded) {
  make();
  for (const auto& name : model_names()) {
    const auto& device = add(name, "my " + name);
    const auto record = device.record();
    EXPECT_EQ(record["definition"]["exposes"].back()["name"], "linkquality") << name;
    EXPECT_EQ(record["interview_state"], "SUCCESSFUL") << name;
    for (const auto& [property, value] : device.model().values.items())
      EXPECT_TRUE(device.model().leaves.contains(property) || property == "color_mode") << name << " " << property;
  }
  EXPECT_FALSE(find_model("toaster"));
}

TEST_F(SimulatedBridge, ASetIsHeardEchoedAndReported) {
  make();
  add("lamp", "lamp");
  start();
  ask("lamp/set", R"({"state":"ON","brightness":40})");
  time.run_for(1s);
  EXPECT_THAT(values("lamp", "state"), ElementsAre(R"("OFF")", R"("ON")", R"("ON")", R"("ON")"));
  const auto seen = values("lamp", "last_seen");
  EXPECT_EQ(seen[0], seen[1]) << "the echo has the time of the message that it was heard";
  EXPECT_NE(seen[1], seen[2]);
  EXPECT_EQ(seen[2], seen[3]) << "two clusters in one moment";
}

TEST_F(SimulatedBridge, ADeviceThatIgnoresASetShowsItsValueOnlyToAGet) {
  make();
  auto& lamp = add("lamp", "lamp");
  start();
  world->radio().set_faults(lamp, {.ignores = true});
  ask("lamp/set", R"({"state":"ON"})");
  time.run_for(10s);
  EXPECT_THAT(values("lamp", "state"), ElementsAre(R"("OFF")", R"("ON")"));
  ask("lamp/get", R"({"state":""})");
  time.run_for(1s);
  EXPECT_EQ(values("lamp", "state").back(), R"("OFF")");
}

TEST_F(SimulatedBridge, ARefusedSetIsOnlyHeardAndASilentDeviceSaysNothing) {
  make();
  auto& lamp = add("lamp", "lamp");
  start();
  world->radio().set_faults(lamp, {.refuses = true});
  ask("lamp/set", R"({"state":"ON"})");
  time.run_for(1s);
  EXPECT_THAT(values("lamp", "state"), ElementsAre(R"("OFF")"));
  published.clear();
  world->radio().set_faults(lamp, {.silent = true});
  ask("lamp/set", R"({"state":"ON"})");
  ask("lamp/get", R"({"state":""})");
  time.run_for(30s);
  EXPECT_THAT(published, IsEmpty());
  time.run_for(40s);
  EXPECT_THAT(of("lamp/availability"), ElementsAre(Json{{"state", "offline"}}));
  world->radio().set_faults(lamp, {});
  EXPECT_EQ(of("lamp/availability").back()["state"], "online");
}

TEST_F(SimulatedBridge, TheEchoMayOvertakeTheMessageThatItWasHeard) {
  make();
  auto& plug = add("plug", "plug");
  start();
  const auto before = plug.last_seen();
  world->radio().set_faults(plug, {.echo_first = true, .delay = 2s});
  ask("plug/set", R"({"state":"OFF"})");
  time.run_for(1s);
  EXPECT_THAT(published, IsEmpty()) << "delayed";
  time.run_for(2s);
  EXPECT_THAT(values("plug", "state"), ElementsAre(R"("OFF")", R"("OFF")", R"("OFF")"));
  EXPECT_EQ(of("plug")[0]["last_seen"], "2025-12-31T23:00:00.000Z");
  EXPECT_LT(before, plug.last_seen());
}

TEST_F(SimulatedBridge, ASleepingDeviceTakesCommandsWhenItWakes) {
  make();
  auto& trv = add("trv", "trv");
  start();
  ask("trv/set", R"({"occupied_heating_setpoint":23.5})");
  ask("trv/get", R"({"occupied_heating_setpoint":""})");
  time.run_for(60s);
  EXPECT_THAT(published, IsEmpty());
  world->radio().report(trv);
  time.run_for(1s);
  EXPECT_EQ(values("trv", "occupied_heating_setpoint").front(), "21");
  EXPECT_EQ(values("trv", "occupied_heating_setpoint").back(), "23.5");
}

TEST_F(SimulatedBridge, WhatABridgeCannotSendIsNotAnswered) {
  make();
  add("lamp", "lamp");
  add("thermometer", "cellar");
  start();
  ask("lamp/set", R"({"state":"BRIGHT"})");
  ask("lamp/set", R"({"brightness":300})");
  ask("lamp/set", R"({"colour":1})");
  ask("lamp/set", R"([1])");
  ask("cellar/set", R"({"temperature":21})");
  ask("absent/set", R"({"state":"ON"})");
  ask("cellar/get", R"({"temperature":""})");
  time.run_for(20s);
  EXPECT_THAT(published, IsEmpty());
  EXPECT_EQ(world->counters().rejected, 7U);
}

TEST_F(SimulatedBridge, ALockReportsWithoutAnEchoAndACoverTravels) {
  make();
  add("lock", "door");
  add("cover", "blind");
  start();
  ask("door/set", R"({"state":"UNLOCK"})");
  time.run_for(1s);
  EXPECT_THAT(values("door", "state"), ElementsAre(R"("LOCK")", R"("UNLOCK")"));
  EXPECT_EQ(of("door").back()["lock_state"], "unlocked");
  ask("blind/set", R"({"position":30})");
  time.run_for(10s);
  EXPECT_THAT(values("blind", "position"), ElementsAre("100", "30", "66", "32", "30"));
  ask("blind/set", "CLOSE");
  time.run_for(10s);
  EXPECT_EQ(of("blind").back()["state"], "CLOSE");
}

TEST_F(SimulatedBridge, ACoverThatLosesItsPositionStops) {
  make();
  auto& blind = add("cover", "blind");
  start();
  ask("blind/set", R"({"position":30})");
  time.run_for(500ms);
  blind.set_real("position", nullptr);
  time.run_for(10s);
  EXPECT_THAT(values("blind", "position"), ElementsAre("100", "30"));
}

TEST_F(SimulatedBridge, ATopicThatADeviceNoLongerHasTakesCommands) {
  make();
  add("lamp", "a");
  auto& renamed = add("lamp", "a/set");
  start();
  world->radio().report(renamed);
  ASSERT_TRUE(world->rename(renamed, "b"));
  ask("a/set", R"({"state":"ON"})");
  time.run_for(1s);
  EXPECT_EQ(of("a").back()["state"], "ON");
  auto& leaving = add("lamp", "b/set");
  world->radio().report(leaving);
  world->leave(leaving.address());
  ask("b/set", R"({"state":"ON"})");
  time.run_for(1s);
  EXPECT_EQ(of("b").back()["state"], "ON");
}

TEST_F(SimulatedBridge, AReportIsOneMessageAndTwoClustersAreTwo) {
  make();
  auto& plug = add("plug", "plug");
  auto& thermometer = add("thermometer", "cellar");
  start();
  world->radio().change(plug, "power", 77);
  EXPECT_THAT(values("plug", "power"), ElementsAre("77"));
  world->radio().report(thermometer);
  const auto seen = values("cellar", "last_seen");
  ASSERT_GE(seen.size(), 2U);
  EXPECT_EQ(seen.front(), seen.back());
}

TEST_F(SimulatedBridge, AnActionIsInOneMessageOnly) {
  make();
  auto& remote = add("remote", "remote");
  start();
  world->radio().act(remote, "action", "toggle");
  world->radio().hear(remote);
  EXPECT_THAT(values("remote", "action"), ElementsAre(R"("toggle")", R"("absent")"));
}

TEST_F(SimulatedBridge, TheBridgeClearsAnOccupancyByItself) {
  make();
  auto& motion = add("motion", "hall");
  start();
  world->radio().change(motion, "occupancy", true);
  time.run_for(2min);
  EXPECT_THAT(values("hall", "occupancy"), ElementsAre("true", "false"));
  EXPECT_EQ(of("hall")[0]["last_seen"], of("hall")[1]["last_seen"]);
}

TEST_F(SimulatedBridge, AGroupIsOffWhenAllItsMembersAre) {
  make();
  add("lamp", "a");
  add("lamp", "b");
  world->registry().add_group(7, "lamps",
                              {world->registry().find("a")->address(), world->registry().find("b")->address()});
  start();
  ask("lamps/set", R"({"state":"ON"})");
  time.run_for(1s);
  EXPECT_EQ(topics().front(), "lamps") << "the group first";
  EXPECT_EQ(of("b").back()["state"], "ON");
  ask("a/set", R"({"state":"OFF"})");
  time.run_for(1s);
  EXPECT_EQ(of("lamps").back()["state"], "ON");
  ask("b/set", R"({"state":"OFF"})");
  time.run_for(1s);
  EXPECT_EQ(of("lamps").back()["state"], "OFF");
}

TEST_F(SimulatedBridge, ALeavingDeviceKeepsItsAvailabilityOnTheBroker) {
  make();
  const auto address = add("plug", "plug").address();
  start();
  world->leave(address);
  EXPECT_THAT(topics(), ElementsAre("bridge/groups", "bridge/devices", "bridge/event")) << "as recorded";
  EXPECT_EQ(of("bridge/event")[0]["type"], "device_leave");
  EXPECT_EQ(world->registry().find("plug"), nullptr);
}

TEST_F(SimulatedBridge, ReportsPeriodicallyAndStopsWithTheBridge) {
  WorldOptions options;
  options.every = 500ms;
  make(options);
  add("plug", "plug");
  start();
  time.run_for(10s);
  EXPECT_THAT(of("plug"), SizeIs(::testing::AllOf(::testing::Ge(38U), ::testing::Le(42U)))) << "two clusters each";
  world->stop();
  EXPECT_EQ(of("bridge/state").back()["state"], "offline");
  published.clear();
  time.run_for(10s);
  EXPECT_THAT(published, IsEmpty());
}

TEST_F(SimulatedBridge, WhatANewDeviceDidNotReportMayBeNull) {
  WorldOptions options;
  options.nulls = options.permit_join = true;
  make(options);
  start();
  const auto address = world->join(find_model("thermometer").value());
  time.run_for(1s);
  EXPECT_FALSE(of(address).front().contains("temperature")) << "the definition is not known yet";
  EXPECT_TRUE(of(address).back()["temperature"].is_null());
  world->radio().report(*world->registry().find(address));
  EXPECT_TRUE(of(address).back()["temperature"].is_number());
}

TEST_F(SimulatedBridge, AnAnnouncedDeviceIsHeardAndKeepsItsRecord) {
  make();
  auto& plug = add("plug", "plug");
  start();
  world->radio().announce(plug);
  EXPECT_THAT(topics(), ElementsAre("plug", "bridge/event"));
  EXPECT_EQ(of("bridge/event")[0]["type"], "device_announce");
}

TEST_F(SimulatedBridge, AListMayBeShortForAMoment) {
  make();
  const auto address = add("plug", "plug").address();
  start();
  world->shrink_list({address});
  time.run_for(1s);
  EXPECT_THAT(of("bridge/devices"), ElementsAre(SizeIs(1), SizeIs(2)));
}

TEST_F(SimulatedBridge, LastSeenHasTheFormOfTheSetting) {
  for (const auto& [setting, wanted] : std::map<std::string, Json>{
           {"epoch", 1767222000000}, {"ISO_8601_local", "2026-01-01T00:00:00+01:00"}, {"disable", "absent"}}) {
    WorldOptions options;
    options.last_seen = setting;
    make(options);
    add("plug", "plug");
    published.clear();
    world->start();
    EXPECT_EQ(of("plug")[0].value("last_seen", Json("absent")), wanted);
  }
}

TEST_F(SimulatedBridge, GeneratedDevicesTakeSetsOverTheWholeGrammar) {
  make();
  DefinitionGenerator generator(3);
  for (std::uint32_t i = 0; i < 50; ++i) ASSERT_TRUE(world->add(make_model(generator, i)));
  start();
  for (auto* device : world->registry().devices()) {
    for (const auto& [property, leaves] : device->model().leaves) {
      if (is_settable(leaves.front()))
        ask(device->name() + "/set", Json{{property, generator.value_of(leaves.front())}}.dump());
      if (is_gettable(leaves.front())) ask(device->name() + "/get", Json{{property, ""}}.dump());
    }
    world->radio().report(*device);
  }
  time.run_for(1min);
  EXPECT_GT(published.size(), 200U);
  for (const auto& one : published) EXPECT_FALSE(one.json().is_discarded()) << one.payload;
}

}  // namespace
}  // namespace rubicon::zigbee_simulator
