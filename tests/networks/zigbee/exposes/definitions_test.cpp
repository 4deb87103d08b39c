#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "networks/zigbee/exposes/exposes_support.h"

namespace rubicon::networks::zigbee::exposes {
namespace {

struct Counts {
  std::size_t definitions = 0, leaves = 0, typed = 0, open = 0, skipped = 0;
  std::map<std::string, std::size_t> unknown_units, open_names;
};

void count(const MappedDefinition& definition, Counts& counts) {
  ++counts.definitions;
  counts.leaves += definition.leaves.size();
  counts.skipped += definition.skipped.size();
  for (const auto& unit : unknown_units(definition.leaves)) ++counts.unknown_units[unit];
  for (std::size_t i = 0; i < definition.leaves.size(); ++i) {
    const auto& leaf = definition.leaves[i];
    const auto& capability = definition.points[i].capability;
    if (all_types().find(capability.point.type) != nullptr) {
      ++counts.typed;
      continue;
    }
    ++counts.open;
    constexpr std::string_view kForms[] = {"numeric", "binary", "enum", "text", "list", "composite"};
    ++counts.open_names[fmt::format("{}/{}/{}/{}/{}", leaf.group, leaf.name, kForms[int(leaf.form)], leaf.unit,
                                    model::to_string(capability.point.kind))];
  }
}

void print_most(const char* what, const std::map<std::string, std::size_t>& names, std::size_t most) {
  std::vector<std::pair<std::size_t, std::string>> sorted;
  for (const auto& [name, times] : names) sorted.emplace_back(times, name);
  std::sort(sorted.rbegin(), sorted.rend());
  std::cout << what << ": " << sorted.size() << " different\n";
  for (std::size_t i = 0; i < std::min(most, sorted.size()); ++i)
    std::cout << "  " << sorted[i].first << " " << sorted[i].second << "\n";
}

/// One definition of Zigbee2MQTT's converter library per line: {"model":...,"exposes":[...]}.
TEST(Definitions, OfAFileMapWithoutALostLeaf) {
  const auto* path = std::getenv("RUBICON_ZIGBEE_DEFINITIONS");
  if (path == nullptr)
    GTEST_SKIP() << "RUBICON_ZIGBEE_DEFINITIONS names no file of definitions, one JSON object a line";
  std::ifstream file(path);
  ASSERT_TRUE(file) << path;
  Counts counts;
  for (std::string line; std::getline(file, line);) {
    const auto record = nlohmann::json::parse(line, nullptr, false);
    ASSERT_TRUE(record.is_object()) << line.substr(0, 200);
    const auto exposes = record.find("exposes");
    if (exposes == record.end() || !exposes->is_array()) {
      std::cout << "no exposes: " << record.value("model", "") << "\n";
      continue;
    }
    const auto definition = map_definition(exposes->dump());
    expect_sound(definition, record.value("model", ""));
    for (const auto& one : definition.skipped) std::cout << record.value("model", "") << " skipped " << one << "\n";
    count(definition, counts);
  }
  EXPECT_GT(counts.leaves, 0U);
  std::cout << fmt::format("{} definitions, {} leaves: {} of the catalogue's types, {} open; {} skipped\n",
                           counts.definitions, counts.leaves, counts.typed, counts.open, counts.skipped);
  print_most("units unknown", counts.unknown_units, 20);
  const auto* most = std::getenv("RUBICON_ZIGBEE_OPEN");
  print_most("open types", counts.open_names, most == nullptr ? 20 : std::stoul(most));
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
