#include "networks/zigbee/exposes/mapping.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "base/assert.h"
#include "base/text.h"
#include "model/point.h"
#include "model/units.h"
#include "networks/zigbee/exposes/point_names.h"
#include "networks/zigbee/exposes/sirens.h"
#include "networks/zigbee/exposes/type_table.h"
#include "networks/zigbee/exposes/units.h"

namespace rubicon::networks::zigbee::exposes {

// Parts of map_leaves(): how values of a leaf become values of a point.

/// Whether the bounds of a numeric leaf, where it has them, are values of the type.
bool is_within_type(const Leaf& leaf, const LeafUnit& unit, const TypeRow& row, const Type& type);
/// The coding of a leaf as a type of the catalogue, and the bounds and words of its capability.
void code_as_type(const Leaf& leaf, const LeafUnit& unit, const TypeRow& row, const Type& type, MappedPoint& point);
/// The same as an open type: with its own unit, words and kind of data.
void code_as_open(const Leaf& leaf, const LeafUnit& unit, MappedPoint& point);

namespace {

using Coding = MappedPoint::Coding;
using model::DataType;

struct Linear {
  double multiply = 1, divide = 1, shift = 0;
};

/// First one, then the other.
Linear joined(const Linear& one, const Linear& other) {
  return {one.multiply * other.multiply, one.divide * other.divide,
          one.shift + other.shift * one.divide / one.multiply};
}

Linear unit_change(std::string_view code, std::string_view to) {
  if (code == "%" && to == "1") return {1, 100};
  if (const auto change = model::conversion(code, to)) return {change->multiply, change->divide, change->shift};
  return {};
}

Linear scale_of(const TypeRow& row, const Leaf& leaf) {
  switch (row.scale) {
    case Scale::kSame: return {};
    case Scale::kShare: return {100, leaf.maximum.value_or(100)};
    case Scale::kClosed: return {-1, 1, -100};
    case Scale::kFraction: return {100, 1};
  }
  return {};
}

/// Numbers among the presets may lie beyond the bounds: 65535 for `as before`.
std::vector<double> preset_numbers(const Leaf& leaf) {
  std::vector<double> numbers;
  for (const auto& preset : leaf.values) {
    const auto number = base::parse_number<double>(preset.json);
    if (number && std::isfinite(*number)) numbers.push_back(*number);
  }
  return numbers;
}

bool has_preset_text(const Leaf& leaf) {
  return std::any_of(leaf.values.begin(), leaf.values.end(),
                     [](const NamedValue& preset) { return preset.json.starts_with('"'); });
}

void set_bounds(const Leaf& leaf, MappedPoint& point) {
  auto low = leaf.minimum, high = leaf.maximum;
  for (const auto number : preset_numbers(leaf)) {
    if (low) low = std::min(*low, number);
    if (high) high = std::max(*high, number);
  }
  const auto& coding = point.coding;
  const model::UnitConversion change{coding.multiply, coding.divide, coding.shift};
  const auto in_type = [&](std::optional<double> bound) {
    if (bound) *bound = change(*bound) + 0.0;
    return bound && std::isfinite(*bound) ? bound : std::nullopt;
  };
  point.capability.minimum = in_type(coding.multiply < 0 ? high : low);
  point.capability.maximum = in_type(coding.multiply < 0 ? low : high);
}

void code_number(const Leaf& leaf, const Linear& change, MappedPoint& point) {
  auto& coding = point.coding;
  coding.form = Coding::Form::kNumber;
  coding.multiply = change.multiply;
  coding.divide = change.divide;
  coding.shift = change.shift;
  coding.minimum = leaf.minimum;
  coding.maximum = leaf.maximum;
  coding.step = leaf.step.value_or(0);
  coding.words = leaf.values;
  set_bounds(leaf, point);
}

std::vector<model::Word> words_of(const Leaf& leaf) {
  std::vector<model::Word> words;
  for (std::uint32_t i = 0; i < leaf.values.size(); ++i) {
    if (!leaf.values[i].name.empty()) words.push_back({i, leaf.values[i].name});
  }
  return words;
}

void code_own_words(const Leaf& leaf, MappedPoint& point) {
  point.coding.form = Coding::Form::kWords;
  point.coding.words = leaf.values;
  point.capability.words = words_of(leaf);
}

/// In the order of the leaf. The point declares those that the device has, by their numbers in the type.
void code_words_of_type(const Leaf& leaf, const TypeRow& row, const Type& type, MappedPoint& point) {
  point.coding.form = Coding::Form::kWords;
  std::set<std::string, std::less<>> had;
  for (const auto& value : leaf.values) {
    point.coding.words.push_back({std::string(type_word(row, value.name)), value.json});
    had.insert(point.coding.words.back().name);
  }
  auto& words = point.capability.words;
  const auto all = model::words_in(type.words);
  for (const auto& word : all) {
    if (had.contains(word.text)) words.push_back(word);
  }
  if (words.size() == all.size()) words.clear();
}

std::string in_capitals(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// A row may define which spelling means on: a lock has value_on UNLOCK in some definitions.
bool is_turned(const Leaf& leaf, const TypeRow& row) {
  return type_word(row, in_capitals(leaf.on.name)) == "off" && type_word(row, in_capitals(leaf.off.name)) == "on";
}

void code_binary(const Leaf& leaf, bool turned, MappedPoint& point) {
  point.coding.form = Coding::Form::kBinary;
  point.coding.words = {leaf.off, leaf.on};
  if (turned) std::swap(point.coding.words[0], point.coding.words[1]);
}

/// Brightness and colour temperature have whole numbers although no definition declares it.
void add_implied_step(const TypeRow& row, MappedPoint& point) {
  if (row.scale != Scale::kShare && row.unit != "mired") return;
  point.coding.rounded = true;
  if (point.coding.step == 0) point.coding.step = 1;
}

Linear change_to_type(const Leaf& leaf, const LeafUnit& unit, const TypeRow& row, const Type& type) {
  const auto to_type = row.scale == Scale::kSame ? unit_change(unit.code, type.unit) : scale_of(row, leaf);
  return joined({unit.multiply, unit.divide, unit.shift}, to_type);
}

/// In the unit of the type; bounds that are no narrower than those of the type add nothing.
void code_quantity(const Leaf& leaf, const LeafUnit& unit, const TypeRow& row, const Type& type, MappedPoint& point) {
  code_number(leaf, change_to_type(leaf, unit, row, type), point);
  if (type.data == DataType::kInteger) point.coding.form = Coding::Form::kInteger;
  add_implied_step(row, point);
  auto& capability = point.capability;
  if (capability.minimum && *capability.minimum <= type.minimum) capability.minimum.reset();
  if (capability.maximum && *capability.maximum >= type.maximum) capability.maximum.reset();
}

void code_structure(const TypeRow& row, MappedPoint& point) {
  if (row.type == "colourXy")
    point.coding.form = Coding::Form::kColourXy;
  else if (row.type == "colourHueSaturation")
    point.coding.form = Coding::Form::kColourHueSaturation;
  else
    point.coding.form = Coding::Form::kObject;
}

DataType data_of(LeafForm form) {
  switch (form) {
    case LeafForm::kNumeric: return DataType::kReal;
    case LeafForm::kBinary: return DataType::kBoolean;
    case LeafForm::kEnum: return DataType::kEnumeration;
    case LeafForm::kText: return DataType::kText;
    case LeafForm::kList:
    case LeafForm::kComposite: break;
  }
  return DataType::kJson;
}

bool says_more_than_on_and_off(const Leaf& leaf) {
  const auto on = in_capitals(leaf.on.name), off = in_capitals(leaf.off.name);
  return !((on == "ON" && off == "OFF") || (on == "TRUE" && off == "FALSE")) && !on.empty() && !off.empty();
}

}  // namespace

bool is_within_type(const Leaf& leaf, const LeafUnit& unit, const TypeRow& row, const Type& type) {
  const auto change = change_to_type(leaf, unit, row, type);
  const model::UnitConversion convert{change.multiply, change.divide, change.shift};
  const auto fits = [&](const std::optional<double>& bound) {
    if (!bound) return true;
    const auto value = convert(*bound);
    return value >= type.minimum && value <= type.maximum;
  };
  return fits(leaf.minimum) && fits(leaf.maximum);
}

void code_as_type(const Leaf& leaf, const LeafUnit& unit, const TypeRow& row, const Type& type, MappedPoint& point) {
  switch (leaf.form) {
    case LeafForm::kNumeric: code_quantity(leaf, unit, row, type, point); return;
    case LeafForm::kBinary: code_binary(leaf, is_turned(leaf, row), point); return;
    case LeafForm::kEnum:
      if (type.words.empty()) return code_own_words(leaf, point);
      return code_words_of_type(leaf, row, type, point);
    case LeafForm::kText: point.coding.form = Coding::Form::kText; return;
    case LeafForm::kList:
    case LeafForm::kComposite: return code_structure(row, point);
  }
}

void code_as_open(const Leaf& leaf, const LeafUnit& unit, MappedPoint& point) {
  point.capability.data = data_of(leaf.form);
  switch (leaf.form) {
    case LeafForm::kNumeric:
      point.capability.unit = unit.code;
      if (has_preset_text(leaf)) point.capability.data.reset();  // a number or the text of a preset
      return code_number(leaf, {unit.multiply, unit.divide, unit.shift}, point);
    case LeafForm::kBinary:
      if (says_more_than_on_and_off(leaf)) point.capability.words = {{0, leaf.off.name}, {1, leaf.on.name}};
      return code_binary(leaf, false, point);
    case LeafForm::kEnum: return code_own_words(leaf, point);
    case LeafForm::kText: point.coding.form = Coding::Form::kText; return;
    case LeafForm::kList:
      point.coding.form = Coding::Form::kList;
      point.coding.parts = leaf.features;
      return;
    case LeafForm::kComposite:
      point.coding.form = Coding::Form::kObject;
      point.coding.parts = leaf.features;
      return;
  }
}

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

/// Adds what depends on the other leaves of a device: `position` beside a thermostat is the position of its valve. Also
/// the plain points of a siren.
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

base::SharedList<MappedPoint> PointsOfModels::of(const std::string& model, const base::SharedList<Leaf>& leaves) {
  auto known = known_.find(model);
  if (known == known_.end() || !(known->second.leaves == leaves)) {
    std::erase_if(known_, [](const auto& one) { return one.second.points.uses() <= 1; });
    Known made{leaves, map_leaves(leaves, types_)};
    known = known_.insert_or_assign(model, std::move(made)).first;
  }
  return known->second.points;
}

std::vector<std::string> unknown_units(const std::vector<Leaf>& leaves) {
  std::vector<std::string> unknown;
  for (const auto& leaf : leaves) {
    if (leaf.form == LeafForm::kNumeric && !unit_of(leaf.unit, leaf.name).known) unknown.push_back(leaf.unit);
  }
  return unknown;
}

}  // namespace rubicon::networks::zigbee::exposes
