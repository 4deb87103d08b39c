#include <gmock/gmock.h>

#include "island/network_types.h"
#include "scenarios/ecology.h"
#include "support/keyring_writer.h"

namespace rubicon::scenarios {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kTwoNetworks = R"(
island: {id: 6541, name: home}
networks:
  dummy-1:
    type: dummy
    simulate:
      hall: {sensors: {temperature-1: {wave: constant, value: 21}}}
      attic: {sensors: {temperature-1: {wave: constant, value: 12}}}
  dummy-2:
    type: dummy
    simulate:
      shed: {sensors: {temperature-1: {wave: constant, value: 5}}}
)";

/// An island made from text, whose file is then changed.
class Reload : public Ecology {
 protected:
  island::IslandConfig read(const std::string& text) {
    const auto tree = config::parse_yaml(text, "island.yaml");
    EXPECT_TRUE(tree) << tree.error().text;
    return island::read_island_config(tree.value(), island::network_types(), errors);
  }
  void start(const std::string& text) {
    auto made = island::Island::make(read(text), scheduler, transports, log, ecology, errors);
    ASSERT_TRUE(made.has_value()) << errors.text();
    island = std::move(*made);
    island->start();
    robot = &component(70001);
    everything = robot->subscribe({OwnerId(6541), "**"}, {.passive = true}, [this](const Event& event) {
      const auto& key = event.tuple.key;
      if (recording && !key.starts_with("proxy.property.") && !key.starts_with("proxy.settings."))
        touched.emplace_back(event.tuple.key);
    });
    scheduler.run_for(1s);
  }
  Result<island::ReloadPlan> reload(const std::string& text) {
    touched.clear();
    recording = true;
    auto done = island->reload(read(text), errors);
    scheduler.run_for(100ms);
    return done;
  }
  static std::string with(std::string text, const std::string& old_part, const std::string& new_part) {
    const auto at = text.find(old_part);
    EXPECT_NE(at, text.npos) << old_part;
    return text.replace(at, old_part.size(), new_part);
  }
  bool exists(const std::string& key) { return robot->get(OwnerId(6541), key).has_value(); }

  base::ConfigErrors errors;
  std::unique_ptr<island::Island> island;
  TupleSpace* robot = nullptr;
  Handle everything;
  bool recording = false;
  std::vector<std::string> touched;
};

TEST_F(Reload, TheSameFileChangesNothing) {
  start(kTwoNetworks);
  const auto plan = reload(std::string("# a comment\n") + kTwoNetworks);
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->lines, IsEmpty());
  EXPECT_THAT(touched, IsEmpty());
}

TEST_F(Reload, AChangedDeviceIsTheOnlyOneTouched) {
  start(kTwoNetworks);
  const auto plan = reload(with(kTwoNetworks, "hall: {sensors", "hall: {name: Hall, sensors"));
  ASSERT_TRUE(plan) << plan.error().text;
  EXPECT_THAT(plan->lines, ElementsAre("network dummy-1: its options change: simulate.hall.name"));
  EXPECT_EQ(json(*robot, 6541, "proxy.dummy-1.hall.description")["name"], "Hall");
  for (const auto& key : touched) EXPECT_THAT(key, HasSubstr("dummy-1.hall")) << key;
  EXPECT_FALSE(touched.empty());
}

TEST_F(Reload, ARemovedDeviceLeavesAndANewOneJoins) {
  start(kTwoNetworks);
  ASSERT_TRUE(reload(with(kTwoNetworks, "attic:", "cellar:")));
  EXPECT_FALSE(exists("proxy.dummy-1.attic.status"));
  EXPECT_TRUE(exists("proxy.dummy-1.cellar.status"));
  EXPECT_TRUE(exists("proxy.dummy-1.hall.status"));
}

TEST_F(Reload, ANetworkThatMustBeRecreatedIsUpAgainByItself) {
  start(kTwoNetworks);
  ASSERT_TRUE(reload(with(kTwoNetworks, "type: dummy\n    simulate:\n      shed",
                          "type: dummy\n    seed: 9\n    simulate:\n      barn")));
  EXPECT_FALSE(exists("proxy.dummy-2.shed.status"));
  EXPECT_TRUE(exists("proxy.dummy-2.barn.status"));
  EXPECT_EQ(json(*robot, 6541, "proxy.dummy-2.status")["line"], "up");
  for (const auto& key : touched) EXPECT_THAT(key, testing::Not(HasSubstr("dummy-1."))) << key;
}

TEST_F(Reload, NetworksComeAndGo) {
  start(kTwoNetworks);
  auto text = with(kTwoNetworks, "dummy-2:", "dummy-3:");
  ASSERT_TRUE(reload(text));
  EXPECT_FALSE(exists("proxy.dummy-2.shed.status"));
  EXPECT_FALSE(exists("proxy.dummy-2.status"));
  EXPECT_TRUE(exists("proxy.dummy-3.shed.status"));
  EXPECT_THAT(island->networks().ids(), ElementsAre("dummy-1", "dummy-3"));
  ASSERT_TRUE(reload(kTwoNetworks));
  EXPECT_TRUE(exists("proxy.dummy-2.shed.status"));
}

TEST_F(Reload, NamesGivenToDevicesTouchNoLine) {
  start(kTwoNetworks);
  const auto plan = reload(
      with(kTwoNetworks, "  dummy-2:\n    type: dummy", "  dummy-2:\n    type: dummy\n    devices: {shed: {id: hut}}"));
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->lines, ElementsAre("network dummy-2: 1 devices are renamed: shed"));
  EXPECT_TRUE(exists("proxy.dummy-2.hut.sensor.temperature-1.value"));
  EXPECT_FALSE(exists("proxy.dummy-2.shed.status"));
}

TEST_F(Reload, NamesThatFitNoPointAreReported) {
  start(kTwoNetworks);
  const auto plan = reload(with(kTwoNetworks, "  dummy-2:\n    type: dummy",
                                "  dummy-2:\n    type: dummy\n    devices: {shed: {sensors: {temprature-1: wall}}}"));
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->warnings,
              ElementsAre("networks.dummy-2.devices.shed.sensors.temprature-1: the device has no such sensor; did you "
                          "mean 'temperature-1'? There are: temperature-1"));
  const auto good = reload(with(kTwoNetworks, "  dummy-2:\n    type: dummy",
                                "  dummy-2:\n    type: dummy\n    devices: {shed: {sensors: {temperature-1: wall}}}"));
  ASSERT_TRUE(good);
  EXPECT_THAT(good->warnings, IsEmpty());
}

TEST_F(Reload, NetworksOfAListThatGetOtherNumbersAreReported) {
  const std::string list = R"(
island: {id: 6541, name: home}
networks:
  - {type: dummy, simulate: {hall: {sensors: {temperature-1: {wave: constant, value: 21}}}}}
  - {type: dummy, simulate: {shed: {sensors: {temperature-1: {wave: constant, value: 5}}}}}
)";
  start(list);
  EXPECT_TRUE(exists("proxy.dummy-2.shed.status"));
  auto shorter = list;
  shorter.erase(list.find("  - "), list.find("  - ", list.find("  - ") + 1) - list.find("  - "));
  const auto plan = reload(shorter);
  ASSERT_TRUE(plan) << plan.error().text;
  EXPECT_THAT(plan->lines,
              ElementsAre("network dummy-2: is called dummy-1 now; stored devices and values stay with the old id",
                          "network dummy-2: is removed with its devices",
                          "network dummy-1: its options change: simulate.shed, simulate.hall"));
  EXPECT_TRUE(exists("proxy.dummy-1.shed.status"));
  EXPECT_FALSE(exists("proxy.dummy-1.hall.status"));
  EXPECT_FALSE(exists("proxy.dummy-2.shed.status"));
  const auto back = reload(list);
  ASSERT_TRUE(back);
  EXPECT_THAT(back->lines, testing::Contains(HasSubstr("network dummy-1: is called dummy-2 now")));
  EXPECT_THAT(reload(list)->lines, IsEmpty());
}

TEST_F(Reload, WrongOptionsOfANetworkAreRefusedAndNothingChanges) {
  start(kTwoNetworks);
  const auto refused = reload(with(with(kTwoNetworks, "value: 5", "value: cold"), "attic", "cellar"));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("island.yaml:"));
  EXPECT_THAT(refused.error().text, HasSubstr("dummy-2"));
  EXPECT_TRUE(exists("proxy.dummy-1.attic.status"));
  EXPECT_THAT(touched, IsEmpty());
}

TEST_F(Reload, WhatNeedsARestartIsRefusedByName) {
  start(kTwoNetworks);
  const auto refused = reload(with(kTwoNetworks, "name: home", "name: house"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_THAT(refused.error().text, HasSubstr("island.name"));
  EXPECT_THAT(touched, IsEmpty());
}

TEST_F(Reload, ReloadsInARowAllHold) {
  start(kTwoNetworks);
  for (int i = 0; i < 20; ++i) {
    const auto other = with(kTwoNetworks, "value: 12", "value: " + std::to_string(i));
    ASSERT_TRUE(island->reload(read(other), errors));
    ASSERT_TRUE(island->reload(read(kTwoNetworks), errors));
  }
  scheduler.run_for(1s);
  EXPECT_TRUE(exists("proxy.dummy-1.attic.status"));
  const auto demand =
      robot->subscribe({OwnerId(6541), "proxy.dummy-1.attic.sensor.temperature-1.value"}, {}, [](const Event&) {});
  scheduler.run_for(2s);
  EXPECT_EQ(value(*robot, 6541, "proxy.dummy-1.attic.sensor.temperature-1.value"), "12");
}

TEST_F(Reload, LimitsAndDiscoveryAreApplied) {
  start(kTwoNetworks);
  const auto plan = reload(std::string(kTwoNetworks) + "limits: {queue: 50}\ndiscovery: {new-devices: ask}\n");
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->lines, ElementsAre("limits change", "discovery rules change"));
}

TEST_F(Reload, ADryRunReportsTheSameAndChangesNothing) {
  start(kTwoNetworks);
  const auto plan = island->plan(read(with(kTwoNetworks, "attic", "cellar")), errors);
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->lines, ElementsAre("network dummy-1: its options change: simulate.cellar, simulate.attic"));
  EXPECT_FALSE(island->plan(read(with(kTwoNetworks, "value: 5", "value: cold")), errors));
  EXPECT_TRUE(exists("proxy.dummy-1.attic.status"));
}

TEST_F(Reload, NamesThatWouldMakeTwoSensorsOneAreRefused) {
  constexpr const char* kPair = R"(
island: {id: 6541}
networks:
  dummy-1:
    type: dummy
    simulate:
      hall: {sensors: {temperature-1: {wave: constant, value: 21}, temperature-2: {wave: constant, value: 22}}}
)";
  start(kPair);
  const auto refused = reload(std::string(kPair) + "    devices: {hall: {sensors: {temperature-1: \"2\"}}}\n");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("temperature-1 and temperature-2 would both become temperature-2"));
  EXPECT_TRUE(exists("proxy.dummy-1.hall.sensor.temperature-1.value"));
}

TEST_F(Reload, AFileThatOptionsNameIsReadAgainWhenItChanged) {
  constexpr const char* kFlat = R"(
island: {id: 6541}
networks: {salad: {type: salad, properties: flat.properties}}
)";
  constexpr const char* kTable =
      "salad_host=localhost\nsalad_port=9000\nrubicon_port=9100\ndevice_1=DOOR,sensor.switch\n";
  transports.put("flat.properties", kTable);
  start(kFlat);
  EXPECT_TRUE(exists("proxy.salad.1.description"));
  transports.put("flat.properties", std::string(kTable) + "device_2=BED,sensor.pressure\n");
  const auto plan = reload(kFlat);
  ASSERT_TRUE(plan) << plan.error().text;
  EXPECT_THAT(plan->lines, ElementsAre("network salad: its properties file changed"));
  EXPECT_TRUE(exists("proxy.salad.2.description"));
  EXPECT_THAT(reload(kFlat)->lines, IsEmpty());
  transports.put("flat.properties", "device_1=DOOR,sensor.balloon\n");
  EXPECT_FALSE(reload(kFlat));
  EXPECT_TRUE(exists("proxy.salad.2.description"));
}

/// With one secured tunnel.
std::string house_keyring(const std::string& password) {
  auto root = support::keyring_root();
  support::KeyringElement tunnel{"Interface"};
  tunnel.text("Type", "Tunneling").text("IndividualAddress", "1.1.201").text("Host", "1.1.0").text("UserID", "4");
  return support::write_keyring(root.add(tunnel.password("Password", "four")), password);
}

TEST_F(Reload, AKeyringThatCannotBeOpenedChangesNothing) {
  constexpr const char* kHouse = R"(
island: {id: 6541}
networks: {knx: {type: knx, via: tunnel-tcp, host: 10.0.0.10, groups: {1/2/7: 9.001}, keyring: house.knxkeys,
                 keyring-password-file: house.password}}
)";
  transports.put("house.knxkeys", house_keyring("ring word"));
  transports.put("house.password", "ring word\n");
  start(kHouse);
  transports.put("house.password", "another word\n");
  const auto wrong = reload(kHouse);
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().text,
              AllOf(HasSubstr("networks.knx.keyring: "), HasSubstr("the password of the keyring is wrong")));
  transports.put("house.password", "ring word\n");
  auto changed = house_keyring("ring word");
  changed.replace(changed.find("1.1.201"), 7, "1.1.202");
  transports.put("house.knxkeys", changed);
  const auto tampered = reload(kHouse);
  ASSERT_FALSE(tampered);
  EXPECT_THAT(tampered.error().text, HasSubstr("the keyring was changed after ETS exported it"));
  EXPECT_THAT(touched, IsEmpty());
  transports.put("house.knxkeys", house_keyring("ring word"));
  EXPECT_THAT(reload(kHouse)->lines, IsEmpty());
}

TEST_F(Reload, EachFileThatOptionsNameIsCompared) {
  constexpr const char* kHouse = R"(
island: {id: 6541}
networks: {knx: {type: knx, via: tunnel-tcp, host: 10.0.0.10, import: flat.yaml, keyring: house.knxkeys,
                 keyring-password-file: house.password}}
)";
  transports.put("flat.yaml", "groups: {1/2/7: 9.001}\n");
  transports.put("house.knxkeys", house_keyring("ring word"));
  transports.put("house.password", "ring word\n");
  start(kHouse);
  EXPECT_THAT(reload(kHouse)->lines, IsEmpty());
  transports.put("house.password", "other word\n");
  transports.put("house.knxkeys", house_keyring("other word"));
  EXPECT_THAT(reload(kHouse)->lines, ElementsAre("network knx: its keyring file, keyring-password-file changed"));
  transports.put("flat.yaml", "groups: {1/2/7: 9.001, 1/2/8: 9.001}\n");
  EXPECT_THAT(reload(kHouse)->lines, ElementsAre("network knx: its import file changed"));
  EXPECT_TRUE(exists("proxy.knx.1_2_8.description"));
  EXPECT_THAT(reload(kHouse)->lines, IsEmpty());
}

TEST_F(Reload, CountersOfARecreatedNetworkAreNotLost) {
  start(kTwoNetworks);
  const auto before = island->gateway().counters().delivered;
  ASSERT_GT(before, 0U);
  ASSERT_TRUE(reload(with(kTwoNetworks, "dummy-2:", "dummy-3:")));
  EXPECT_GE(island->gateway().counters().delivered, before);
}

TEST_F(Reload, RecordersComeChangeAndGo) {
  start(kTwoNetworks);
  const std::string one = kTwoNetworks + std::string("recorders: {all: {file: a.rec, patterns: [\"proxy.**\"]}}\n");
  auto plan = reload(one);
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->lines, ElementsAre("recorder all: starts"));
  scheduler.run_for(3s);
  const auto size = transports.bytes("a.rec").size();
  EXPECT_GT(size, 100U);
  EXPECT_GT(std::stoi(value(*robot, 6541, "proxy.property.recorder-all-records.value")), 0);
  EXPECT_THAT(reload(one)->lines, IsEmpty());
  plan = reload(with(one, "a.rec", "b.rec"));
  EXPECT_THAT(plan->lines, ElementsAre("recorder all: is restarted, its options change"));
  scheduler.run_for(3s);
  EXPECT_TRUE(transports.has("b.rec"));
  EXPECT_THAT(reload(kTwoNetworks)->lines, ElementsAre("recorder all: ends"));
  scheduler.run_for(2s);
  EXPECT_FALSE(exists("proxy.property.recorder-all-records.value"));
}

}  // namespace
}  // namespace rubicon::scenarios
