#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "model/type_names.h"
#include "networks/zigbee/exposes/mapping.h"
#include "networks/zigbee/exposes/point_names.h"
#include "networks/zigbee/exposes/sirens.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee::exposes {

/// The definition of a device as the network sees it.
struct MappedDefinition {
  std::vector<Leaf> leaves;
  std::vector<std::string> skipped;
  std::vector<MappedPoint> points;
};

inline const TypeCatalogue& all_types() {
  static const TypeCatalogue types;
  return types;
}

inline MappedDefinition map_definition(const std::string& exposes) {
  MappedDefinition definition;
  auto leaves = read_exposes(exposes, definition.skipped);
  EXPECT_TRUE(leaves) << leaves.error().text;
  if (leaves) definition.leaves = std::move(*leaves);
  definition.points = map_leaves(definition.leaves, all_types());
  return definition;
}

/// Lines of tests/cases/zigbee/<name>, divided at their tabs; comments begin with `#`.
inline std::vector<std::vector<std::string>> rows_of_cases(const std::string& name) {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/zigbee/" + name);
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    auto& row = rows.emplace_back();
    for (std::size_t tab = 0; tab != line.npos;) {
      tab = line.find('\t');
      row.push_back(line.substr(0, tab));
      if (tab != line.npos) line.erase(0, tab + 1);
    }
  }
  return rows;
}

/// What must hold of the points of any definition: none lost, ids that are unique and fit into keys.
inline void expect_sound(const MappedDefinition& definition, const std::string& what) {
  const auto& [leaves, skipped, points] = definition;
  ASSERT_GE(points.size(), leaves.size()) << what;
  std::size_t sirens = 0;
  for (const auto& leaf : leaves) sirens += siren_leaves(leaf).size();
  ASSERT_LE(points.size(), leaves.size() + sirens + 1) << what;
  std::set<PointId> ids;
  std::set<std::string> keys;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& capability = points[i].capability;
    const auto& id = capability.point;
    EXPECT_TRUE(ids.insert(id).second) << what << ": " << points[i].property;
    const auto type = model::name_in_keys(capability);
    EXPECT_LE(capability.type_name.size(), 255U) << what;
    const auto limit = id.kind == Kind::kProperty ? 64U : 40U;
    if (!id.instance.empty()) {
      EXPECT_EQ(model::to_key_part(id.instance, limit), id.instance) << what;
    } else {
      EXPECT_EQ(id.kind, Kind::kProperty) << what;
    }
    EXPECT_TRUE(keys.insert(fmt::format("{}.{}-{}", model::to_string(id.kind), type, id.instance)).second) << what;
    const auto* known = all_types().find(id.type);
    if (known != nullptr) {
      EXPECT_EQ(known->name, capability.type_name) << what;
    } else {
      EXPECT_GE(static_cast<std::uint16_t>(id.type), model::kFirstOpenType) << what;
      EXPECT_EQ(all_types().find(type), nullptr) << what << ": an open type has the name of another";
    }
    if (i < leaves.size()) {
      EXPECT_EQ(points[i].property, leaves[i].property) << what;
    }
  }
}

}  // namespace rubicon::networks::zigbee::exposes
