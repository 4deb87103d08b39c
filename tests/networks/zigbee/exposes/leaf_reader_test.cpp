#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "networks/zigbee/exposes/exposes_support.h"

namespace rubicon::networks::zigbee::exposes {
namespace {

std::vector<Leaf> leaves_in(const std::string& json, std::vector<std::string>& skipped) {
  auto leaves = read_exposes(json, skipped);
  EXPECT_TRUE(leaves) << leaves.error().text;
  return leaves.value_or(std::vector<Leaf>());
}

std::vector<Leaf> leaves_in(const std::string& json) {
  std::vector<std::string> skipped;
  auto leaves = leaves_in(json, skipped);
  EXPECT_TRUE(skipped.empty());
  return leaves;
}

std::string why_not(const std::string& json) {
  std::vector<std::string> skipped;
  const auto leaves = read_exposes(json, skipped);
  return leaves ? "read" : leaves.error().text;
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(LeafReader, AGroupGivesItsLeavesItsNameAndEndpoint) {
  const auto leaves = leaves_in(
      R"([{"type":"switch","endpoint":"left","features":[{"type":"binary","name":"state","property":"state_left",)"
      R"("access":7,"label":"State","value_on":"ON","value_off":"OFF"}]}])");
  ASSERT_EQ(leaves.size(), 1U);
  EXPECT_EQ(leaves[0].group, "switch");
  EXPECT_EQ(leaves[0].endpoint, "left");
  EXPECT_EQ(leaves[0].label, "State");
  EXPECT_EQ(leaves[0].on, (NamedValue{"ON", "\"ON\""}));
  EXPECT_EQ(leaves[0].access, (LeafAccess{true, true, true}));
}

TEST(LeafReader, AnEndpointMayBeANumber) {
  EXPECT_EQ(leaves_in(R"([{"type":"text","name":"a","property":"a_1","endpoint":1,"access":1}])")[0].endpoint, "1");
}

TEST(LeafReader, ValuesMayBeAnyScalar) {
  const auto leaves =
      leaves_in(R"([{"type":"enum","name":"a","property":"a","access":1,"values":["on",30,1.5,true]},)"
                R"({"type":"binary","name":"b","property":"b","access":1,"value_on":1,"value_off":null}])");
  const std::vector<NamedValue> values{{"on", "\"on\""}, {"30", "30"}, {"1.5", "1.5"}, {"true", "true"}};
  EXPECT_EQ(leaves[0].values, values);
  EXPECT_EQ(leaves[1].off, (NamedValue{"null", "null"}));
}

TEST(LeafReader, PresetsMayBeTextsFractionsAndNull) {
  const auto leaf = leaves_in(
      R"([{"type":"numeric","name":"a b","property":"a b","access":3,"value_min":-0.5,"value_max":9,"value_step":0.25,)"
      R"("presets":[{"name":"x","value":"previous"},{"name":"y","value":-12.8},{"name":"z","value":null},7]}])")[0];
  EXPECT_EQ(leaf.values, (std::vector<NamedValue>{{"x", "\"previous\""}, {"y", "-12.8"}, {"z", "null"}}));
  EXPECT_EQ(leaf.minimum, -0.5);
  EXPECT_EQ(leaf.step, 0.25);
  EXPECT_EQ(leaf.property, "a b");
}

TEST(LeafReader, ListsAndCompositesKeepTheirParts) {
  const auto leaves =
      leaves_in(R"([{"type":"list","name":"l","property":"l","access":1,"item_type":{"type":"composite","features":[)"
                R"({"type":"composite","name":"in","property":"in","features":[{"type":"text","name":"t"}]}]}},)"
                R"({"type":"list","name":"m","property":"m","access":1}])");
  ASSERT_EQ(leaves[0].features.size(), 1U);
  ASSERT_EQ(leaves[0].features[0].features.size(), 1U);
  EXPECT_EQ(leaves[0].features[0].features[0].features[0].name, "t");
  EXPECT_TRUE(leaves[1].features.empty());
}

TEST(LeafReader, TwoLeavesMayHaveOneProperty) {
  const auto leaves = leaves_in(
      R"([{"type":"light","features":[{"type":"composite","name":"color_xy","property":"color","access":7,"features":[]},)"
      R"({"type":"composite","name":"color_hs","property":"color","access":7,"features":[]}]}])");
  EXPECT_EQ(leaves.size(), 2U);
}

TEST(LeafReader, WhatIsNoLeafIsSkippedAndNamed) {
  std::vector<std::string> skipped;
  const auto leaves =
      leaves_in(R"([null,7,[],{"type":"numeric"},{"type":7,"name":"n","property":"n","access":1},{"type":"light"},)"
                R"({"type":"numeric","name":"zero","property":"zero","access":0},)"
                R"({"type":"numeric","name":"none","property":"none"},)"
                R"({"type":"numeric","name":"text","property":"text","access":"1"},)"
                R"({"type":"enum","name":"e","property":"e","access":1,"values":[{},"ok",null]}])",
                skipped);
  ASSERT_EQ(leaves.size(), 1U);
  EXPECT_EQ(leaves[0].values, (std::vector<NamedValue>{{"ok", "\"ok\""}, {"null", "null"}}));
  EXPECT_EQ(skipped.size(), 10U);
  EXPECT_EQ(skipped[6], "'zero': it has access 0");
}

TEST(LeafReader, WrongKindsOfMembersReadAsAbsent) {
  const auto leaf = leaves_in(
      R"([{"type":"numeric","name":"a","property":"a","access":1,"unit":5,"label":[],"category":{},"value_min":"0",)"
      R"("value_max":null,"value_step":-1,"presets":{},"endpoint":null}])")[0];
  EXPECT_EQ(leaf.unit, "");
  EXPECT_EQ(leaf.minimum, std::nullopt);
  EXPECT_EQ(leaf.step, std::nullopt);
  EXPECT_EQ(leaf.endpoint, "");
}

TEST(LeafReader, BoundsTheWrongWayRoundAreTurned) {
  const auto leaf =
      leaves_in(R"([{"type":"numeric","name":"a","property":"a","access":1,"value_min":9,"value_max":1}])");
  EXPECT_EQ(leaf[0].minimum, 1);
  EXPECT_EQ(leaf[0].maximum, 9);
}

TEST(LeafReader, WhatIsNoListIsRefused) {
  EXPECT_EQ(why_not("{}"), "exposes: expected a JSON array");
  EXPECT_EQ(why_not(""), "exposes: expected a JSON array");
  EXPECT_EQ(why_not("[{]"), "exposes: expected a JSON array");
  EXPECT_EQ(why_not("[\"\xff\"]"), "exposes: expected a JSON array") << "no UTF-8";
  EXPECT_EQ(why_not("[]"), "read");
}

TEST(LeafReader, DepthAndSizeAreBounded) {
  EXPECT_EQ(why_not(repeated("[", 100'000)), "exposes: nested more than 32 times");
  EXPECT_EQ(why_not("[" + repeated(R"({"type":"light","features":[)", 20)), "exposes: nested more than 32 times");
  EXPECT_EQ(why_not("[\"" + repeated("[", 1000) + "\\\"[\"]"), "read") << "brackets inside a string";
  EXPECT_EQ(why_not(std::string((1 << 20) + 1, ' ')), "exposes of 1048577 bytes");
}

TEST(LeafReader, NumbersAndLengthsAreBounded) {
  std::vector<std::string> skipped;
  const std::string leaf = R"({"type":"text","name":"a","property":"a","access":1},)";
  EXPECT_EQ(leaves_in("[" + repeated(leaf, 3000) + "0]", skipped).size(), 512U);
  EXPECT_EQ(skipped.size(), 100U) << "no endless list of what was skipped";
  skipped.clear();
  const auto name = std::string(300'000, 'n');
  EXPECT_TRUE(leaves_in(R"([{"type":"text","name":")" + name + R"(","property":"a","access":1}])", skipped).empty());
  ASSERT_EQ(skipped.size(), 1U);
  EXPECT_LT(skipped[0].size(), 200U);
}

TEST(LeafReader, WordsOfBinariesAndPresetsAreShortScalars) {
  std::vector<std::string> skipped;
  const std::string fits(512, 'w'), longer(513, 'w');
  const auto binary = [](const std::string& on, const std::string& off) {
    return R"({"type":"binary","name":"b","property":"b","access":1,"value_on":)" + on + R"(,"value_off":)" + off + "}";
  };
  const auto text = [](const std::string& word) { return "\"" + word + "\""; };
  const auto leaves =
      leaves_in("[" + binary(text(fits), "0") + "," + binary(text(longer), "0") + "," + binary("1", text(longer)) +
                    "," + binary("{}", "0") + "," + binary("1", "[7]") + "]",
                skipped);
  ASSERT_EQ(leaves.size(), 1U);
  EXPECT_EQ(leaves[0].on.name, fits);
  EXPECT_EQ(skipped, std::vector<std::string>(4, "'b': value_on or value_off is too long or not a scalar"));
  const auto presets =
      leaves_in(R"([{"type":"numeric","name":"a","property":"a","access":3,"presets":[{"name":"x","value":)" +
                text(longer) + R"(},{"name":"y","value":)" + text(fits) + R"(},{"name":"z","value":{}}]}])");
  EXPECT_EQ(presets[0].values, (std::vector<NamedValue>{{"y", text(fits)}}));
}

/// zigbee.md, section 13: the device list of a real Zigbee2MQTT.
TEST(LeafReader, ReadsTheDevicesOfARealBridge) {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/zigbee/bridge_devices.json");
  const auto list = nlohmann::json::parse(file, nullptr, false);
  if (!list.is_array()) GTEST_SKIP() << "no ../shared/data/zigbee/bridge_devices.json beside the source tree";
  EXPECT_EQ(list.size(), 17U);
  std::map<std::string, std::size_t> entries, leaves;
  for (const auto& record : list) {
    if (!record.contains("definition")) continue;
    const auto& exposes = record["definition"]["exposes"];
    const auto definition = map_definition(exposes.dump());
    EXPECT_TRUE(definition.skipped.empty());
    EXPECT_EQ(definition.points.size(), definition.leaves.size()) << "the link quality is exposed";
    const auto model = record.value("model_id", "");
    entries[model] = exposes.size();
    leaves[model] = definition.leaves.size();
    expect_sound(definition, model);
  }
  const std::map<std::string, std::size_t> expected{{"LCT015", 7},
                                                    {"SNZB-02", 5},
                                                    {"SP 120", 6},
                                                    {"lumi.sensor_motion.aq2", 7},
                                                    {"lumi.sensor_magnet.aq2", 8},
                                                    {"TRADFRI control outlet", 4},
                                                    {"lumi.weather", 6},
                                                    {"BASICZBR3", 2}};
  for (const auto& [model, count] : expected) {
    const auto found = std::find_if(entries.begin(), entries.end(),
                                    [&](const auto& one) { return one.first.find(model) != one.first.npos; });
    ASSERT_NE(found, entries.end()) << model;
    EXPECT_EQ(found->second, count) << model;
  }
  EXPECT_EQ(leaves["LCT015"], 12U) << "six leaves of the light";
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
