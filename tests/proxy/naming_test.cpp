#include "proxy/naming.h"

#include "island.h"

namespace rubicon::proxy {
namespace {

TEST(Naming, TurnsAddressesIntoKeyParts) {
  NetworkRules rules;
  rules.devices["7"].id = "kitchen";
  EXPECT_EQ(device_id(rules, "1.4.6"), "1_4_6");
  EXPECT_EQ(device_id(rules, "7"), "kitchen");
}

TEST(Naming, WritesTypeAndInstanceAlwaysBoth) {
  const auto types = test_types();
  EXPECT_EQ(point_id(nullptr, capability(Kind::kSensor, kGlow, "3"), types.find(kGlow)), "glow-3");
  EXPECT_EQ(point_id(nullptr, capability(Kind::kSensor, kGlow, ""), types.find(kGlow)), "glow-1");
}

TEST(Naming, ReplacesTheInstanceByTheInstalledName) {
  const auto types = test_types();
  DeviceNames names;
  names.sensors["glow-1"] = "window";
  EXPECT_EQ(point_id(&names, capability(Kind::kSensor, kGlow, "1"), types.find(kGlow)), "glow-window");
  EXPECT_EQ(point_id(&names, capability(Kind::kSensor, kGlow, "2"), types.find(kGlow)), "glow-2");
  EXPECT_EQ(point_id(&names, capability(Kind::kActuator, kGlow, "1"), types.find(kGlow)), "glow-1");
  EXPECT_EQ(point_id(&names, capability(Kind::kProperty, kKnob, "glow-1"), types.find(kKnob)), "knob-glow-window");
}

TEST(Naming, NamesADevicePropertyByItsTypeAlone) {
  const auto types = test_types();
  EXPECT_EQ(point_id(nullptr, capability(Kind::kProperty, kKnob, ""), types.find(kKnob)), "knob");
}

TEST(Naming, UsesTheNameANetworkGivesToAForeignType) {
  auto foreign = capability(Kind::kSensor, TypeId{0x9999}, "1");
  EXPECT_EQ(point_id(nullptr, foreign, nullptr), "type39321-1");
  foreign.type_name = "soil-moisture";
  EXPECT_EQ(point_id(nullptr, foreign, nullptr), "soil_moisture-1");
}

TEST(Naming, AnEntryUnderAnAnnouncedNameBecomesThatOfTheAddress) {
  NetworkRules rules;
  rules.devices["Kitchen"].id = "kitchen";
  rules.devices["8"].id = "hall";
  EXPECT_FALSE(adopt_names(rules, "7", "Kitchen")) << "names are not unique there";
  rules.unique_names = true;
  EXPECT_FALSE(adopt_names(rules, "7", ""));
  EXPECT_FALSE(adopt_names(rules, "8", "Kitchen")) << "it has an entry of its own";
  ASSERT_TRUE(adopt_names(rules, "7", "Kitchen"));
  EXPECT_EQ(device_id(rules, "7"), "kitchen");
  EXPECT_FALSE(adopt_names(rules, "9", "Kitchen")) << "it belongs to 7, whatever 7 is called later";
}

TEST(Naming, FindsIdsThatCollideInAConfiguration) {
  ProxyConfig config;
  config.networks["knx"].devices["1.4.6"];
  config.networks["knx"].devices["1_4_6"];
  config.networks["wsn"].devices["7"].sensors = {{"glow-1", "window"}, {"glow-2", "window"}};
  const auto lines = collisions(config);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "networks.knx.devices: 1.4.6 and 1_4_6 both become 1_4_6");
  EXPECT_EQ(lines[1], "networks.wsn.devices.7.sensors: glow-1 and glow-2 both become glow-window");
}

TEST(Naming, FindsNothingWrongWithASoundConfiguration) {
  ProxyConfig config;
  config.networks["knx"].devices["1.4.6"].id = "door";
  config.networks["knx"].devices["1.4.7"].sensors = {{"glow-1", "window"}, {"knob-1", "window"}};
  EXPECT_TRUE(collisions(config).empty());
}

}  // namespace
}  // namespace rubicon::proxy
