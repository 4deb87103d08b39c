#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/simulators/zigbee/definition_generator.h"
#include "networks/zigbee/exposes/exposes_support.h"

// Definitions over the whole grammar, as the simulator makes them.

namespace rubicon::networks::zigbee::exposes {
namespace {

using zigbee_simulator::DefinitionGenerator;
using zigbee_simulator::leaves_of;
using TreeOfJson = nlohmann::json;

constexpr int kDefinitions = 10'000;

/// Numbers may have other digits: 0.30000000000000004 and 0.3.
bool same_json(const TreeOfJson& one, const TreeOfJson& other, double tolerance) {
  if (!one.is_number() || !other.is_number()) return one == other;
  const auto a = one.get<double>(), b = other.get<double>();
  return std::abs(a - b) <= tolerance + 1e-9 * std::max({1.0, std::abs(a), std::abs(b)});
}

/// The members of a colour that its type has.
TreeOfJson coordinates(const MappedPoint& point, const TreeOfJson& colour) {
  const bool xy = point.coding.form == MappedPoint::Coding::Form::kColourXy;
  const auto *first = xy ? "x" : "hue", *second = xy ? "y" : "saturation";
  if (!colour.is_object() || !colour.contains(first) || !colour.contains(second)) return nullptr;
  if (!colour[first].is_number() || !colour[second].is_number()) return nullptr;
  return {{first, colour[first]}, {second, colour[second]}};
}

bool is_colour_point(const MappedPoint& point) {
  using Form = MappedPoint::Coding::Form;
  return point.coding.form == Form::kColourXy || point.coding.form == Form::kColourHueSaturation;
}

/// The grammar gives coordinates of colours no bounds.
TreeOfJson colour(int number) {
  const auto part = number % 1000 / 1000.0;
  return {{"x", part}, {"y", 1 - part}, {"hue", number % 361}, {"saturation", number % 101}, {"more", true}};
}

/// What the grammar does not contain: colours are in their bounds, counters are whole.
TreeOfJson reported(DefinitionGenerator& generator, const TreeOfJson& leaf, const MappedPoint& point, int number) {
  auto value = generator.value_of(leaf);
  if (is_colour_point(point)) return colour(number);
  const bool whole = point.coding.form == MappedPoint::Coding::Form::kInteger && value.is_number();
  return whole ? TreeOfJson(std::llround(value.get<double>())) : value;
}

void expect_round_trip(MappedPoint point, const TreeOfJson& value) {
  point.access.settable = true;  // so that what only reports is tried as well
  const auto published = value.dump();
  const auto known = decode(point, published);
  ASSERT_TRUE(known) << point.property << ": " << known.error().text;
  if (known->index() == 0) {
    EXPECT_TRUE(value.is_null() || is_colour_point(point)) << published;
    return;
  }
  const auto sent = encode(point, *known);
  // Of a composite the generator makes members beyond its features, which a command may not have (commands.tsv).
  if (!sent && !point.coding.parts.empty()) return;
  ASSERT_TRUE(sent) << point.property << " " << published << ": " << sent.error().text;
  const auto expected = is_colour_point(point) ? coordinates(point, value) : value;
  const auto to_the_grid = point.coding.rounded ? point.coding.step / 2 : 0;
  EXPECT_TRUE(same_json(TreeOfJson::parse(*sent), expected, to_the_grid))
      << point.property << ": " << published << " became " << *sent;
}

/// Leaves that are no leaf to us are named in `skipped`.
void expect_complete(const MappedDefinition& definition, const std::vector<TreeOfJson>& leaves) {
  std::size_t next = 0, left_out = 0;
  for (const auto& leaf : leaves) {
    const bool there =
        next < definition.leaves.size() && definition.leaves[next].property == leaf.value("property", "");
    next += there ? 1U : 0U;
    left_out += there ? 0U : 1U;
  }
  EXPECT_EQ(next, definition.leaves.size());
  EXPECT_EQ(left_out, definition.skipped.size());
}

TEST(GeneratedDefinitions, NoLeafIsLostAndWhatADeviceReportsCanBeSentBack) {
  DefinitionGenerator generator(16);
  std::size_t leaves = 0;
  for (int i = 0; i < kDefinitions && !testing::Test::HasFailure(); ++i) {
    const auto exposes = generator.exposes();
    const auto definition = map_definition(exposes.dump());
    expect_sound(definition, "definition " + std::to_string(i));
    const auto all = leaves_of(exposes);
    expect_complete(definition, all);
    std::size_t next = 0;
    for (const auto& leaf : all) {
      if (next >= definition.leaves.size() || definition.leaves[next].property != leaf.value("property", "")) continue;
      const auto& point = definition.points[next++];
      expect_round_trip(point, reported(generator, leaf, point, i));
    }
    leaves += next;
  }
  EXPECT_GT(leaves, 50'000U);
}

TEST(GeneratedDefinitions, TheSameLeavesGiveTheSamePoints) {
  DefinitionGenerator generator(18);
  for (int i = 0; i < 500; ++i) {
    const auto exposes = generator.exposes().dump();
    EXPECT_EQ(map_definition(exposes).points, map_definition(exposes).points);
  }
}

/// A new version of a definition has a leaf more, at its end.
TEST(GeneratedDefinitions, AFurtherLeafChangesNoOther) {
  DefinitionGenerator generator(19);
  for (int i = 0; i < 2000 && !testing::Test::HasFailure(); ++i) {
    auto exposes = generator.exposes();
    const auto before = map_definition(exposes.dump());
    exposes.push_back(generator.leaf());
    const auto after = map_definition(exposes.dump());
    for (std::size_t k = 0; k < before.leaves.size(); ++k)
      EXPECT_EQ(before.points[k], after.points[k]) << exposes.dump();
  }
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
