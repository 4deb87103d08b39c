#include "client/names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::client {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Given {
  std::uint32_t island;
  const char *network, *id, *name, *address, *area;
  std::vector<std::string> sensors{}, actuators{}, properties{};
};

/// Two islands, and what houses have: umlauts, dots, slashes and colons in names, one name twice, a room.
KnownNames house() {
  const std::vector<Given> all{
      {6541,
       "dummy-rooms",
       "living",
       "Living room",
       "living",
       "",
       {"light-1"},
       {"lamp-1", "blindPosition-1"},
       {"rate"}},
      {6541, "log-flat", "kitchen", "Kitchen air", "kitchen", "Kitchen", {"temperature-1", "humidity-1"}},
      {6541, "zigbee", "0x01", "living/ceiling", "0x01", "", {}, {"lamp-1"}, {"threshold-light-1"}},
      {6541, "knx", "1_4_6", "Küche: Decke", "1.4.6", "Kitchen", {}, {"lamp-1", "lamp-2"}},
      {6541, "knx", "1_4_7", "Fridge No. 2", "1.4.7", "", {"contact-door", "power-1"}},
      {7, "wsn-1", "9", "Mote", "9", "Attic", {"temperature-1"}},
      {7, "wsn-1", "10", "Mote", "10", "Attic", {"temperature-1", "temperature-out"}},
      {7, "wsn-1", "kitchen2", "living", "11", "", {}, {"led-1"}},
  };
  KnownNames names{{}, {{OwnerId(6541), "home"}, {OwnerId(7), "Hut"}, {OwnerId(8), "hut"}}};
  for (const auto& one : all) {
    Device device;
    device.island = OwnerId(one.island);
    device.prefix = "proxy";
    device.network = one.network;
    device.id = one.id;
    device.name = one.name;
    device.address = one.address;
    device.area = one.area;
    device.sensors = one.sensors;
    device.actuators = one.actuators;
    device.properties = one.properties;
    names.devices.push_back(std::move(device));
  }
  return names;
}

std::vector<std::string> points(std::string_view text, Among among = Among::kAll) {
  std::vector<std::string> found;
  for (const auto& point : points_called(house(), text, among)) found.push_back(to_string(point));
  return found;
}

TEST(NamesOfPeople, APointIsNamedAsPeopleNameIt) {
  const std::vector<std::pair<const char*, const char*>> table{
      {"living.lamp-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"},
      {"dummy-rooms.living.lamp-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"},
      {"proxy.dummy-rooms.living.lamp-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"},
      {"Living room.lamp-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"},
      {"living room.LAMP-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"},
      {"Living room.lamp", "6541:proxy.dummy-rooms.living.actuator.lamp-1"},
      {"Living room.blindposition", "6541:proxy.dummy-rooms.living.actuator.blindPosition-1"},
      {"Living room.illuminance-1", "6541:proxy.dummy-rooms.living.sensor.light-1"},
      {"Living room.sampling-rate", "6541:proxy.dummy-rooms.living.property.rate"},
      {"Living room.*", "6541:proxy.dummy-rooms.living.*.*"},
      {"Living room.l*", "6541:proxy.dummy-rooms.living.*.l*"},
      {"living/ceiling.lamp-1", "6541:proxy.zigbee.0x01.actuator.lamp-1"},
      {"KÜCHE: decke.lamp-2", "6541:proxy.knx.1_4_6.actuator.lamp-2"},
      {"1.4.6.lamp-1", "6541:proxy.knx.1_4_6.actuator.lamp-1"},
      {"Fridge No. 2.door", "6541:proxy.knx.1_4_7.sensor.contact-door"},
      {"kitchen.temperature", "6541:proxy.log-flat.kitchen.sensor.temperature-1"},
      {"Kitchen.lamp-1", "6541:proxy.knx.1_4_6.actuator.lamp-1"},
      {"10.out", "7:proxy.wsn-1.10.sensor.temperature-out"},
      {"living.led-1", "7:proxy.wsn-1.kitchen2.actuator.led-1"},
      {"home:Living room.lamp-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"},
      {"HOME:Living room.lamp-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"},
      {"Hut:9.temperature", "7:proxy.wsn-1.9.sensor.temperature-1"},
      {"7:kitchen2.led-1", "7:proxy.wsn-1.kitchen2.actuator.led-1"},
      {"*:Living room.light-1", "6541:proxy.dummy-rooms.living.sensor.light-1"},
  };
  for (const auto& [text, key] : table) EXPECT_THAT(points(text), ElementsAre(key)) << text;
}

TEST(NamesOfPeople, WhatSeveralPointsAreCalledNamesAllOfThem) {
  EXPECT_THAT(points("Mote.temperature-1"),
              ElementsAre("7:proxy.wsn-1.9.sensor.temperature-1", "7:proxy.wsn-1.10.sensor.temperature-1"));
  EXPECT_THAT(points("10.temperature"),
              ElementsAre("7:proxy.wsn-1.10.sensor.temperature-1", "7:proxy.wsn-1.10.sensor.temperature-out"));
  EXPECT_THAT(points("1.4.6.lamp"),
              ElementsAre("6541:proxy.knx.1_4_6.actuator.lamp-1", "6541:proxy.knx.1_4_6.actuator.lamp-2"));
  EXPECT_THAT(points("Attic.temp*"), ElementsAre("7:proxy.wsn-1.9.*.temp*", "7:proxy.wsn-1.10.*.temp*"));
}

TEST(NamesOfPeople, WhatNothingIsCalledNamesNothing) {
  for (const auto* text :
       {"", ".", "living", "living.", ".lamp-1", "living.foo", "nobody.lamp-1", "7:living.lamp-1", "hut:9.temperature",
        "Nowhere:Mote.temperature-1", "living.1", "0x01.light-1", "Living room.z*"})
    EXPECT_THAT(points(text), IsEmpty()) << text;
}

TEST(NamesOfPeople, OnlyWhatIsNoSensorCanBeSet) {
  EXPECT_THAT(points("kitchen.temperature", Among::kSettable), IsEmpty());
  EXPECT_THAT(points("Living room.light-1", Among::kSettable), IsEmpty());
  EXPECT_THAT(points("kitchen.lamp-2", Among::kSettable), IsEmpty()) << "the device kitchen has none, only the room";
  EXPECT_THAT(points("kitchen.lamp-2"), ElementsAre("6541:proxy.knx.1_4_6.actuator.lamp-2"));
  EXPECT_THAT(points("Living room.rate", Among::kSettable), ElementsAre("6541:proxy.dummy-rooms.living.property.rate"));
}

std::vector<std::string> devices(std::string_view text) {
  std::vector<std::string> found;
  for (const auto& device : devices_called(house(), text)) found.push_back(device.network + "." + device.id);
  return found;
}

TEST(NamesOfPeople, ADeviceIsCalledByKeyThenByNameThenByItsRoom) {
  EXPECT_THAT(devices("living"), ElementsAre("dummy-rooms.living")) << "before the device that has this name";
  EXPECT_THAT(devices("wsn-1.9"), ElementsAre("wsn-1.9"));
  EXPECT_THAT(devices("Living Room"), ElementsAre("dummy-rooms.living"));
  EXPECT_THAT(devices("1.4.6"), ElementsAre("knx.1_4_6"));
  EXPECT_THAT(devices("mote"), ElementsAre("wsn-1.9", "wsn-1.10"));
  EXPECT_THAT(devices("attic"), ElementsAre("wsn-1.9", "wsn-1.10"));
  EXPECT_THAT(devices("Küche: Decke"), ElementsAre("knx.1_4_6")) << "no island is called Küche";
  EXPECT_THAT(devices("6541:Mote"), IsEmpty());
  EXPECT_THAT(devices(""), IsEmpty());
}

TEST(NamesOfPeople, ATypingMistakeGetsNamesOfPeople) {
  const auto near = [](std::string_view text, Among among = Among::kAll) { return near_points(house(), text, among); };
  EXPECT_THAT(near("Livng room.lamp-1"), ElementsAre("Living room.lamp-1"));
  EXPECT_THAT(near("home:Livng room.lamp"), ElementsAre("home:Living room.lamp"));
  EXPECT_THAT(near("Küche: Deke.lamp-1"), ElementsAre("Küche: Decke.lamp-1"));
  EXPECT_THAT(near("Living room.lmp-1"), ElementsAre("Living room.lamp-1"));
  EXPECT_THAT(near("living.light-2", Among::kSettable), IsEmpty()) << "a sensor cannot be set";
  EXPECT_THAT(near("frob.nicate"), IsEmpty());
  EXPECT_THAT(near("Living room.lamp-1"), IsEmpty()) << "never what was typed";
}

TEST(NamesOfPeople, WhatIsNeitherNameNorKeyIsSeen) {
  for (const auto* text : {"Küche.lamp-1", "a b", "living/ceiling.lamp-1", "x"})
    EXPECT_TRUE(is_like_name(text)) << text;
  for (const auto* text : {"", ".a", "a.", "a..b", "a\nb"}) EXPECT_FALSE(is_like_name(text)) << text;
}

}  // namespace
}  // namespace rubicon::client
