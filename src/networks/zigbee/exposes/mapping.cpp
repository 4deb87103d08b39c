#include "networks/zigbee/exposes/mapping.h"

#include <algorithm>
#include <array>
#include <utility>

#include "networks/zigbee/exposes/coding.h"
#include "networks/zigbee/exposes/point_names.h"
#include "networks/zigbee/exposes/sirens.h"
#include "networks/zigbee/exposes/type_table.h"
#include "networks/zigbee/exposes/units.h"

namespace rubicon::networks::zigbee::exposes {

namespace {

constexpr std::string_view kLinkQuality = "linkquality";

/// Keys that Zigbee2MQTT never keeps in a state (zigbee.md, section 5).
constexpr std::array<std::string_view, 17> kUncached{
    "action",         "button",    "button_left", "button_right",       "click",    "forgotten",
    "keyerror",       "step_size", "step_mode",   "transition_time",    "duration", "group_list",
    "group_capacity", "from_side", "to_side",     "no_occupancy_since", "elapsed"};

bool is_uncached(std::string_view property) {
  return property.starts_with("action_") || std::find(kUncached.begin(), kUncached.end(), property) != kUncached.end();
}

Leaf link_quality_leaf() {
  Leaf leaf;
  leaf.name = leaf.property = kLinkQuality;
  leaf.unit = "lqi";
  leaf.access.published = true;
  leaf.category = Category::kDiagnostic;
  leaf.minimum = 0;
  leaf.maximum = 255;
  return leaf;
}

/// The row of a leaf and what makes its point one of several of the type.
struct Found {
  const TypeRow* row = nullptr;
  const Type* type = nullptr;
  std::string tag;
};

/// A row that matches by the unit alone is only for leaves whose bounds the type has; others become open types, because
/// values beyond the bounds of a type would be bad.
Found found_with(const TypeRow* row, std::string_view matched, const Leaf& leaf, const LeafUnit& unit,
                 const TypeCatalogue& types) {
  if (row == nullptr) return {};
  const auto* type = types.find(row->type);
  if (row->name == "*" && type != nullptr && !is_within_type(leaf, unit, *row, *type)) return {};
  return {row, type, std::string(row->instance.empty() ? matched : row->instance)};
}

/// By its name; a leaf whose property has another name means that (`state` of the property `window_detection`).
Found find_row(const Leaf& leaf, const LeafUnit& unit, const TypeCatalogue& types) {
  std::string_view matched;
  const auto property = own_property(leaf);
  const auto find = [&](std::string_view group, std::string_view name) {
    const auto* row = row_of(leaf, group, name, unit.code, matched);
    return found_with(row, matched, leaf, unit, types);
  };
  if (property == leaf.name) return find(leaf.group, leaf.name);
  auto found = find("", property);
  if (found.row != nullptr) return found;
  found = find(leaf.group, leaf.name);
  found.tag = property;
  return found;
}

/// Types of the catalogue's properties (docs/types.md): settings, whatever the category of the leaf.
bool is_property_type(const Type* type) {
  constexpr unsigned kFirst = 0x0600, kLast = 0x06ff;
  const auto id = type == nullptr ? 0U : unsigned{static_cast<std::uint16_t>(type->id)};
  return id >= kFirst && id <= kLast;
}

Kind kind_of(const Leaf& leaf, const Type* type) {
  if (leaf.category == Category::kConfig || is_property_type(type)) return Kind::kProperty;
  return leaf.access.settable ? Kind::kActuator : Kind::kSensor;
}

model::Access access_of(const Leaf& leaf, Kind kind) {
  if (kind == Kind::kSensor || !leaf.access.settable) return model::Access::kRead;
  return leaf.access.published ? model::Access::kReadWrite : model::Access::kWrite;
}

void describe(const Leaf& leaf, const Found& found, MappedPoint& point) {
  auto& capability = point.capability;
  const bool actuator = capability.point.kind == Kind::kActuator;
  capability.access = access_of(leaf, capability.point.kind);
  const bool event = found.type != nullptr && found.type->report == model::Report::kEvent;
  capability.reports = !leaf.access.settable || (leaf.access.published && !event);
  capability.sampled = actuator && leaf.access.published && leaf.access.gettable;
  capability.deadline = Duration::zero();  // devices report changes; their own liveness decides
  point.property = leaf.property;
  point.access = leaf.access;
  point.event = is_uncached(own_property(leaf));
  point.coding.part = leaf.part;
  if (!leaf.part.empty()) capability.access = model::Access::kReadWrite;  // kept here, and shown as assumed
  if (point.event && found.type == nullptr) capability.report = model::Report::kEvent;
}

MappedPoint map_leaf(const Leaf& leaf, const TypeCatalogue& types, PointNames& names) {
  const auto unit = unit_of(leaf.unit, own_property(leaf), leaf.maximum);
  const auto found = find_row(leaf, unit, types);
  MappedPoint point;
  const auto kind = kind_of(leaf, found.type);
  if (found.type != nullptr) {
    point.capability.point.type = found.type->id;
    point.capability.type_name = found.type->name;
    code_as_type(leaf, unit, *found.row, *found.type, point);
  } else {
    point.capability.type_name = open_name(leaf, types);
    point.capability.point.type = names.open_type_of(point.capability.type_name);
    code_as_open(leaf, unit, point);
  }
  point.capability.point.kind = kind;
  names.name(leaf, found.type != nullptr ? found.tag : open_tag(leaf), point.capability);
  describe(leaf, found, point);
  return point;
}

bool has_group(const std::vector<Leaf>& leaves, std::string_view group) {
  return std::any_of(leaves.begin(), leaves.end(), [&](const Leaf& leaf) { return leaf.group == group; });
}

/// What only the other leaves of a device tell: `position` beside a thermostat is that of its valve; and the plain
/// points of a siren.
std::vector<Leaf> completed(std::vector<Leaf> leaves) {
  const bool thermostat = has_group(leaves, "climate") && !has_group(leaves, "cover");
  for (auto& leaf : leaves) {
    if (thermostat && leaf.group.empty() && leaf.name == "position") leaf.group = "climate";
  }
  for (std::size_t i = 0, exposed = leaves.size(); i < exposed; ++i) {
    for (auto& one : siren_leaves(leaves[i])) leaves.push_back(std::move(one));
  }
  return leaves;
}

}  // namespace

std::vector<MappedPoint> map_leaves(const std::vector<Leaf>& exposed, const TypeCatalogue& types, bool link_quality) {
  const auto leaves = completed(exposed);
  std::vector<MappedPoint> points;
  PointNames names;
  for (const auto& leaf : leaves) points.push_back(map_leaf(leaf, types, names));
  const bool has_quality =
      std::any_of(leaves.begin(), leaves.end(), [](const Leaf& leaf) { return leaf.property == kLinkQuality; });
  if (link_quality && !has_quality) points.push_back(map_leaf(link_quality_leaf(), types, names));
  names.name_properties(leaves, points);
  return points;
}

std::vector<std::string> unknown_units(const std::vector<Leaf>& leaves) {
  std::vector<std::string> unknown;
  for (const auto& leaf : leaves) {
    if (leaf.form == LeafForm::kNumeric && !unit_of(leaf.unit, leaf.name).known) unknown.push_back(leaf.unit);
  }
  return unknown;
}

}  // namespace rubicon::networks::zigbee::exposes
