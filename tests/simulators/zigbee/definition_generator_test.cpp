#include "apps/simulators/zigbee/definition_generator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>

namespace rubicon::zigbee_simulator {
namespace {

using Json = nlohmann::json;

std::vector<Json> many_exposes() {
  DefinitionGenerator generator(1);
  std::vector<Json> all;
  for (int i = 0; i < 3000; ++i) all.push_back(generator.exposes());
  return all;
}

const std::vector<Json>& exposes_of_all() {
  static const auto all = many_exposes();
  return all;
}

/// Whether a leaf of the definitions, or a part of one, fits.
bool some_leaf(const std::function<bool(const Json& leaf)>& fits) {
  const std::function<bool(const Json&)> below = [&](const Json& leaf) {
    if (fits(leaf)) return true;
    if (leaf.contains("item_type") && below(leaf["item_type"])) return true;
    return leaf.contains("features") && std::ranges::any_of(leaf["features"], below);
  };
  return std::ranges::any_of(exposes_of_all(),
                             [&](const Json& exposes) { return std::ranges::any_of(leaves_of(exposes), below); });
}

TEST(DefinitionGenerator, TheSameSeedGivesTheSameDefinitions) {
  DefinitionGenerator one(7), same(7), other(8);
  const auto record = one.device_record(3);
  EXPECT_EQ(record, same.device_record(3));
  EXPECT_NE(record, other.device_record(3));
  EXPECT_EQ(record["ieee_address"], "0x00124b0020000003");
}

TEST(DefinitionGenerator, DefinitionsAreAsLargeAsThoseOfTheLibrary) {
  std::vector<std::size_t> counts;
  for (const auto& exposes : exposes_of_all()) counts.push_back(leaves_of(exposes).size());
  std::ranges::sort(counts);
  EXPECT_EQ(counts.front(), 0U);
  EXPECT_THAT(counts[counts.size() / 2], ::testing::AllOf(::testing::Ge(4U), ::testing::Le(8U)));
  EXPECT_THAT(counts[counts.size() * 9 / 10], ::testing::AllOf(::testing::Ge(10U), ::testing::Le(20U)));
  EXPECT_GT(counts.back(), 200U);
}

TEST(DefinitionGenerator, EachFormAndGroupAndAccessComes) {
  std::set<std::string> types;
  std::set<int> accesses;
  for (const auto& exposes : exposes_of_all()) {
    for (const auto& expose : exposes) types.insert(expose["type"]);
    for (const auto& leaf : leaves_of(exposes)) accesses.insert(leaf["access"].get<int>());
  }
  EXPECT_THAT(types, ::testing::UnorderedElementsAre("numeric", "binary", "enum", "text", "list", "composite", "switch",
                                                     "light", "climate", "cover", "lock", "fan"));
  EXPECT_THAT(accesses, ::testing::IsSupersetOf({1, 2, 3, 5, 7}));
}

TEST(DefinitionGenerator, TheOdditiesOfTheLibraryCome) {
  const std::map<std::string, std::function<bool(const Json&)>> oddities{
      {"on is a boolean", [](auto& leaf) { return leaf.contains("value_on") && leaf["value_on"].is_boolean(); }},
      {"on is a number", [](auto& leaf) { return leaf.contains("value_on") && leaf["value_on"].is_number(); }},
      {"on is false", [](auto& leaf) { return leaf.contains("value_on") && leaf["value_on"] == false; }},
      {"words are integers",
       [](auto& leaf) { return leaf.contains("values") && !leaf["values"].empty() && leaf["values"][0].is_number(); }},
      {"800 words", [](auto& leaf) { return leaf.contains("values") && leaf["values"].size() == 800; }},
      {"a preset is null",
       [](auto& leaf) {
         return leaf.contains("presets") &&
                std::ranges::any_of(leaf["presets"], [](auto& one) { return one["value"].is_null(); });
       }},
      {"a bound is a fraction",
       [](auto& leaf) { return leaf.contains("value_min") && leaf["value_min"].is_number_float(); }},
      {"a composite in a composite",
       [](auto& leaf) {
         return leaf["type"] == "composite" &&
                std::ranges::any_of(leaf["features"], [](auto& part) { return part["type"] == "composite"; });
       }},
      {"an item without a property",
       [](auto& leaf) { return leaf["type"] == "list" && !leaf["item_type"].contains("property"); }},
      {"a property with a space",
       [](auto& leaf) { return leaf.value("property", "").find(" setting") != std::string::npos; }},
      {"a name of hundreds of bytes", [](auto& leaf) { return leaf.value("name", "").size() > 300; }},
      {"an endpoint", [](auto& leaf) { return leaf.contains("endpoint"); }},
      {"an unknown unit", [](auto& leaf) { return leaf.value("unit", "") == "furlong/fortnight"; }},
  };
  for (const auto& [name, fits] : oddities) EXPECT_TRUE(some_leaf(fits)) << name;
}

TEST(DefinitionGenerator, TwoLeavesShareAPropertyInSomeDefinitions) {
  const auto shares = [](const Json& exposes) {
    std::set<std::string> seen;
    return std::ranges::any_of(leaves_of(exposes), [&](auto& leaf) { return !seen.insert(leaf["property"]).second; });
  };
  EXPECT_GT(std::ranges::count_if(exposes_of_all(), shares), 30);
}

TEST(DefinitionGenerator, AStateHasAValueForEachPublishedProperty) {
  DefinitionGenerator generator(5);
  for (int i = 0; i < 200; ++i) {
    const auto exposes = generator.exposes();
    const auto state = generator.state_of(exposes);
    for (const auto& leaf : leaves_of(exposes))
      EXPECT_TRUE((leaf["access"].get<int>() & 1) == 0 || state.contains(leaf["property"].get<std::string>()));
  }
}

TEST(DefinitionGenerator, ValuesLieWithinTheBoundsOfTheirLeaf) {
  DefinitionGenerator generator(9);
  for (int i = 0; i < 2000; ++i) {
    const auto leaf = generator.leaf();
    if (leaf["type"] != "numeric") continue;
    const auto value = generator.value_of(leaf).get<double>();
    EXPECT_GE(value, leaf.value("value_min", value)) << leaf;
    EXPECT_LE(value, leaf.value("value_max", value)) << leaf;
  }
}

}  // namespace
}  // namespace rubicon::zigbee_simulator
