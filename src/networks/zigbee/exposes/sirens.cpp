#include "networks/zigbee/exposes/sirens.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::networks::zigbee::exposes {

namespace {

using Tree = nlohmann::json;

/// Warning Duration of the command Start Warning is a uint16 of seconds (ZigBee Cluster Library, section 8.4.2.3.1).
constexpr double kMaxTime = 65535;
/// Without a duration Zigbee2MQTT uses 10 s: too short for a siren that is switched on.
constexpr double kUsual = 1800;

const Leaf* part_of(const Leaf& leaf, std::string_view name, LeafForm form) {
  const auto found = std::find_if(leaf.features.begin(), leaf.features.end(), [&](const Leaf& part) {
    return part.name == name && part.property == name && part.form == form;
  });
  return found == leaf.features.end() ? nullptr : &*found;
}

const NamedValue* word_of(const Leaf& part, std::string_view name) {
  const auto found =
      std::find_if(part.values.begin(), part.values.end(), [&](const NamedValue& word) { return word.name == name; });
  return found == part.values.end() ? nullptr : &*found;
}

double most_of(const Leaf& duration) {
  return std::min(duration.maximum.value_or(kMaxTime), kMaxTime);
}

/// `emergency` is what Zigbee2MQTT takes for a missing mode; else the first word that is not the end.
const NamedValue* alarm_of(const Leaf& mode) {
  if (const auto* emergency = word_of(mode, "emergency")) return emergency;
  const auto other =
      std::find_if(mode.values.begin(), mode.values.end(), [](const NamedValue& word) { return word.name != "stop"; });
  return other == mode.values.end() ? nullptr : &*other;
}

/// Each part is set: Zigbee2MQTT takes values of its own for those that are missing, also for the end.
NamedValue siren_value(const Leaf& leaf, const NamedValue& mode, bool on) {
  Tree object{{"mode", model::parse_json(mode.json)}};
  if (const auto* level = part_of(leaf, "level", LeafForm::kEnum); level && !level->values.empty())
    object["level"] = model::parse_json(on ? level->values.back().json : level->values.front().json);
  if (const auto* strobe = part_of(leaf, "strobe", LeafForm::kBinary))
    object["strobe"] = model::parse_json(on ? strobe->on.json : strobe->off.json);
  if (const auto* duration = part_of(leaf, "duration", LeafForm::kNumeric))
    object["duration"] = std::llround(on ? std::min(kUsual, most_of(*duration)) : duration->minimum.value_or(0));
  return {on ? "on" : "off", model::dump(object)};
}

Leaf derived(const Leaf& leaf, std::string name, LeafForm form) {
  Leaf part;
  part.form = form;
  part.name = std::move(name);
  part.property = leaf.property;
  part.endpoint = leaf.endpoint;
  part.access.settable = true;
  return part;
}

}  // namespace

std::vector<Leaf> siren_leaves(const Leaf& leaf) {
  if (leaf.form != LeafForm::kComposite || !leaf.access.settable) return {};
  const auto* mode = part_of(leaf, "mode", LeafForm::kEnum);
  const auto* stop = mode == nullptr ? nullptr : word_of(*mode, "stop");
  const auto* alarm = mode == nullptr ? nullptr : alarm_of(*mode);
  if (stop == nullptr || alarm == nullptr) return {};
  std::vector<Leaf> leaves{derived(leaf, "siren", LeafForm::kBinary)};
  leaves[0].on = siren_value(leaf, *alarm, true);
  leaves[0].off = siren_value(leaf, *stop, false);
  if (const auto* duration = part_of(leaf, "duration", LeafForm::kNumeric)) {
    auto& added = leaves.emplace_back(derived(leaf, "siren_duration", LeafForm::kNumeric));
    added.category = Category::kConfig;
    added.unit = duration->unit;
    added.minimum = duration->minimum.value_or(0);
    added.maximum = most_of(*duration);
    added.step = 1;
    added.part = duration->name;
  }
  if (mode->values.size() > 2) {
    auto& added = leaves.emplace_back(derived(leaf, "melody", LeafForm::kEnum));
    added.category = Category::kConfig;
    added.values = mode->values;
    std::erase_if(added.values, [](const NamedValue& word) { return word.name == "stop"; });
    added.part = mode->name;
  }
  if (const auto* level = part_of(leaf, "level", LeafForm::kEnum)) {
    auto& added = leaves.emplace_back(derived(leaf, "alarm_volume", LeafForm::kEnum));
    added.category = Category::kConfig;
    added.values = level->values;
    added.part = level->name;
  }
  return leaves;
}

std::string with_parts(std::string_view object, const std::map<std::string, std::string>& parts) {
  auto tree = model::object_of(object);
  for (const auto& [name, json] : parts) tree[name] = model::parse_json(json);
  return model::dump(tree);
}

}  // namespace rubicon::networks::zigbee::exposes
