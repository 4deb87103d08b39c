#include "apps/simulators/zigbee/definition_generator.h"

#include <fmt/format.h>

#include <cmath>

#include "apps/simulators/zigbee/definition_words.h"

namespace rubicon::zigbee_simulator {

namespace {

using Json = nlohmann::json;

constexpr int kMaxLeaves = 276;
constexpr int kDeepest = 4;

/// Pairs of value_on and value_off (zigbee.md, section 10), with their frequencies.
struct Spelling {
  Json on, off;
};

const std::array<Spelling, 10>& spellings() {
  static const std::array<Spelling, 10> all{{{"ON", "OFF"},
                                             {true, false},
                                             {"LOCK", "UNLOCK"},
                                             {false, true},
                                             {"Enabled", "Disabled"},
                                             {1, 0},
                                             {"open", "close"},
                                             {"", "x"},
                                             {0, 1},
                                             {"true", "false"}}};
  return all;
}
constexpr std::array<int, 10> kSpellingWeights{4977, 2346, 216, 129, 60, 20, 20, 5, 5, 10};

void flatten(const Json& expose, std::vector<Json>& leaves) {
  if (!expose.is_object()) return;
  if (expose.contains("property") || expose.value("type", "") == "composite") {
    leaves.push_back(expose);
    return;
  }
  const auto features = expose.find("features");
  if (features == expose.end() || !features->is_array()) return;
  for (const auto& feature : *features) flatten(feature, leaves);
}

int access_of(const Json& leaf) {
  return leaf.value("access", 0);
}

}  // namespace

std::vector<Json> leaves_of(const Json& exposes) {
  std::vector<Json> leaves;
  if (!exposes.is_array()) return leaves;
  for (const auto& expose : exposes) flatten(expose, leaves);
  return leaves;
}

DefinitionGenerator::DefinitionGenerator(std::uint64_t seed) : random_(seed) {}

void DefinitionGenerator::begin_definition() {
  endpoints_.clear();
  endpoint_.clear();
  if (!random_.chance(120)) return;
  const std::array<std::vector<std::string>, 5> kinds{
      {{"l1", "l2", "l3", "l4"}, {"left", "right", "center"}, {"1", "2"}, {"l1", "l2"}, {"meter é", "a_b"}}};
  endpoints_ = random_.one_of(kinds);
}

std::string DefinitionGenerator::made_name() {
  std::string name;
  for (auto i = random_.between(1, 5); i >= 0; --i) name += random_.one_of(kSyllables);
  if (random_.chance(5)) name.append(random_.below(500), 'n');
  return name;
}

template <class Names>
std::string DefinitionGenerator::name_from(const Names& names) {
  return random_.chance(650) ? std::string(random_.one_of(names)) : made_name();
}

Json DefinitionGenerator::common(std::string_view type, std::string name) {
  constexpr std::array<int, 6> kAccess{7, 1, 3, 2, 5, 0}, kWeights{18865, 7198, 6784, 3853, 3278, 2};
  const int access = kAccess[random_.weighted(kWeights)];
  Json leaf{{"type", type}, {"name", name}, {"property", name}, {"access", access}, {"label", name}};
  if (random_.chance(134) && access != 1 && access != 5) leaf["category"] = "config";
  if (random_.chance(300) && (access == 1 || access == 5)) leaf["category"] = "diagnostic";
  if (random_.chance(600)) leaf["description"] = "Says what " + name + " is for, with \"quotes\" and °.";
  if (random_.chance(2)) leaf["property"] = name + " setting";
  if (random_.chance(10)) leaf["property"] = made_name();
  if (!endpoint_.empty()) name_endpoint(leaf);
  if (endpoint_.empty() && !endpoints_.empty() && random_.chance(300)) {
    endpoint_ = random_.one_of(endpoints_);
    name_endpoint(leaf);
    endpoint_.clear();
  }
  return leaf;
}

void DefinitionGenerator::name_endpoint(Json& leaf) {
  leaf["endpoint"] = endpoint_;
  leaf["property"] = leaf["name"].get<std::string>() + "_" + endpoint_;
}

void DefinitionGenerator::add_range(Json& leaf) {
  if (!random_.chance(590)) return;
  static const std::array<std::array<double, 3>, 8> kRanges{{{0, 100, 1},
                                                             {0, 254, 0},
                                                             {5, 30, 0.5},
                                                             {-5, 5, 0.1},
                                                             {0, 65535, 1},
                                                             {0, 1, 0.01},
                                                             {-20.5, 59.75, 0.25},
                                                             {153, 500, 0}}};
  const auto& range = random_.one_of(kRanges);
  const auto number = [](double value) { return value == std::floor(value) ? Json(std::llround(value)) : Json(value); };
  if (!random_.chance(30)) leaf["value_min"] = number(range[0]);
  if (!random_.chance(30)) leaf["value_max"] = number(range[1]);
  if (range[2] != 0 && random_.chance(500)) leaf["value_step"] = number(range[2]);
}

void DefinitionGenerator::add_presets(Json& leaf) {
  if (!random_.chance(90)) return;
  auto presets = Json::array({{{"name", "coolest"}, {"value", 1}, {"description", "the least"}}});
  if (random_.chance(500)) presets.push_back({{"name", "previous"}, {"value", 65535}});
  if (random_.chance(100)) presets.push_back({{"name", "as before"}, {"value", "previous"}});
  if (random_.chance(50)) presets.push_back({{"name", "half"}, {"value", 0.5}});
  if (random_.chance(50)) presets.push_back({{"name", "none"}, {"value", nullptr}});
  leaf["presets"] = std::move(presets);
}

Json DefinitionGenerator::numeric(std::string_view name) {
  auto leaf = common("numeric", name.empty() ? name_from(kNumericNames) : std::string(name));
  const auto unit = random_.chance(850) ? random_.one_of(kCommonUnits) : random_.one_of(kRareUnits);
  if (!unit.empty() || random_.chance(1)) leaf["unit"] = unit;
  add_range(leaf);
  add_presets(leaf);
  return leaf;
}

Json DefinitionGenerator::binary(std::string_view name) {
  auto leaf = common("binary", name.empty() ? name_from(kBinaryNames) : std::string(name));
  const auto& spelling = spellings()[random_.weighted(kSpellingWeights)];
  leaf["value_on"] = spelling.on;
  leaf["value_off"] = spelling.off;
  if (random_.chance(300)) leaf["value_toggle"] = "TOGGLE";
  return leaf;
}

Json DefinitionGenerator::enumeration(std::string_view name) {
  auto leaf = common("enum", name.empty() ? name_from(kEnumNames) : std::string(name));
  const bool whole = random_.chance(5);
  auto count = random_.chance(2) ? 800 : 1 + static_cast<int>(random_.below(8));
  auto values = Json::array();
  for (int i = 0; i < count; ++i) {
    Json value = whole ? Json(i) : Json(random_.one_of(kWords));
    if (count > 20) value = fmt::format("tune {}", i);
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(std::move(value));
  }
  leaf["values"] = std::move(values);
  return leaf;
}

Json DefinitionGenerator::text() {
  return common("text", name_from(kTextNames));
}

Json DefinitionGenerator::list(int depth) {
  constexpr std::array<int, 4> kWeights{46, 43, 10, 8};
  auto leaf = common("list", name_from(kTextNames));
  const auto kind = random_.weighted(kWeights);
  auto item = kind == 0 ? composite(depth + 1) : kind == 1 ? text() : kind == 2 ? enumeration() : numeric();
  if (random_.chance(700)) item.erase("property");
  leaf["item_type"] = std::move(item);
  if (random_.chance(300)) leaf["length_min"] = 1;
  if (random_.chance(400)) leaf["length_max"] = 10;
  return leaf;
}

Json DefinitionGenerator::composite(int depth) {
  auto leaf = common("composite", name_from(kTextNames));
  const auto endpoint = std::exchange(endpoint_, {});
  auto features = Json::array();
  for (auto i = random_.between(1, 4); i > 0; --i) features.push_back(any_leaf(depth + 1));
  leaf["features"] = std::move(features);
  endpoint_ = endpoint;
  return leaf;
}

Json DefinitionGenerator::any_leaf(int depth) {
  constexpr std::array<int, 6> kWeights{10732, 8535, 3680, 1316, 321, 62};
  switch (random_.weighted(kWeights)) {
    case 0: return numeric();
    case 1: return enumeration();
    case 2: return binary();
    case 3: return text();
    case 4: return depth < kDeepest ? composite(depth) : text();
    default: return depth < kDeepest ? list(depth) : text();
  }
}

Json DefinitionGenerator::leaf() {
  endpoints_.clear();
  return any_leaf(0);
}

Json DefinitionGenerator::settable(Json leaf, int access) {
  leaf["access"] = access;
  leaf.erase("category");
  return leaf;
}

Json DefinitionGenerator::light() {
  const auto ranged = [&](const char* name, int low, int high) {
    auto leaf = settable(common("numeric", name));
    leaf["value_min"] = low;
    leaf["value_max"] = high;
    return leaf;
  };
  auto features = Json::array({settable(binary("state")), ranged("brightness", 0, 254)});
  features[0]["value_on"] = "ON";
  features[0]["value_off"] = "OFF";
  if (random_.chance(650)) {
    features.push_back(ranged("color_temp", 153, 500));
    features.back()["unit"] = "mired";
    add_presets(features.back());
    if (random_.chance(800)) features.push_back(ranged("color_temp_startup", 153, 500));
  }
  const auto colour = [&](const char* name, const char* first, const char* second) {
    auto leaf = settable(common("composite", name));
    leaf["property"] = endpoint_.empty() ? "color" : "color_" + endpoint_;
    leaf["features"] = Json::array({{{"type", "numeric"}, {"name", first}, {"property", first}, {"access", 7}},
                                    {{"type", "numeric"}, {"name", second}, {"property", second}, {"access", 7}}});
    features.push_back(std::move(leaf));
  };
  if (random_.chance(380)) colour("color_xy", "x", "y");
  if (random_.chance(300)) colour("color_hs", "hue", "saturation");
  if (random_.chance(100)) {
    features.push_back(composite(1));
    features.back()["name"] = "level_config";
  }
  return features;
}

Json DefinitionGenerator::climate() {
  auto features = Json::array();
  for (const auto* name : {"occupied_heating_setpoint", "current_heating_setpoint", "unoccupied_heating_setpoint"}) {
    if (!random_.chance(500)) continue;
    auto leaf = settable(common("numeric", name));
    leaf.update({{"unit", "°C"}, {"value_min", 5}, {"value_max", 35}, {"value_step", 0.5}});
    features.push_back(std::move(leaf));
  }
  features.push_back(settable(common("numeric", "local_temperature"), 5));
  features.back()["unit"] = "°C";
  features.push_back(settable(enumeration("system_mode")));
  features.back()["values"] = {"off", "heat", "auto"};
  if (random_.chance(600)) features.push_back(settable(enumeration("running_state"), 5));
  if (random_.chance(400)) features.push_back(settable(enumeration("preset")));
  if (random_.chance(400)) features.push_back(settable(numeric("local_temperature_calibration")));
  if (random_.chance(200)) features.push_back(settable(numeric("pi_heating_demand"), 1));
  return features;
}

Json DefinitionGenerator::cover() {
  auto features = Json::array({settable(enumeration("state"), 3)});
  features[0]["values"] = {"OPEN", "CLOSE", "STOP"};
  for (const auto* name : {"position", "tilt"}) {
    if (!random_.chance(name[0] == 'p' ? 900 : 250)) continue;
    features.push_back(settable(common("numeric", name)));
    features.back().update({{"unit", "%"}, {"value_min", 0}, {"value_max", 100}});
  }
  return features;
}

Json DefinitionGenerator::lock() {
  auto features = Json::array({settable(binary("state")), settable(enumeration("lock_state"), 1)});
  features[0]["value_on"] = "LOCK";
  features[0]["value_off"] = "UNLOCK";
  features[1]["values"] = {"not_fully_locked", "locked", "unlocked"};
  return features;
}

Json DefinitionGenerator::fan() {
  auto features = Json::array({settable(binary("state"), 3), settable(enumeration("mode"))});
  if (random_.chance(500)) features.push_back(settable(numeric("speed")));
  return features;
}

Json DefinitionGenerator::group(std::string_view type) {
  if (!endpoints_.empty()) endpoint_ = random_.one_of(endpoints_);
  Json group{{"type", type}};
  if (!endpoint_.empty()) group["endpoint"] = endpoint_;
  if (type == "light") group["features"] = light();
  if (type == "climate") group["features"] = climate();
  if (type == "cover") group["features"] = cover();
  if (type == "lock") group["features"] = lock();
  if (type == "fan") group["features"] = fan();
  if (type == "switch") group["features"] = Json::array({settable(binary("state"))});
  endpoint_.clear();
  return group;
}

Json DefinitionGenerator::expose() {
  constexpr std::array<int, 7> kWeights{24646, 1873, 1768, 274, 174, 50, 13};
  constexpr std::array<std::string_view, 7> kGroups{"", "switch", "light", "climate", "cover", "lock", "fan"};
  const auto chosen = random_.weighted(kWeights);
  return chosen == 0 ? any_leaf(0) : group(kGroups[chosen]);
}

Json DefinitionGenerator::exposes() {
  begin_definition();
  auto all = Json::array();
  if (random_.chance(6)) return all;
  // Median 6 leaves, 90 % have at most 16, one in a hundred more than 38, one of all 276.
  auto wanted =
      static_cast<std::size_t>(1 + 5 * std::exp(1.0 * (random_.share() + random_.share() + random_.share() - 1.4)));
  if (random_.chance(20)) wanted = 20 + random_.below(40);
  if (random_.chance(1)) wanted = kMaxLeaves - 20;
  while (leaves_of(all).size() < wanted) all.push_back(expose());
  if (random_.chance(10)) all.push_back(Json(all[random_.below(all.size())]));  // two leaves on one property
  return all;
}

Json DefinitionGenerator::options() {
  auto all = Json::array();
  for (auto i = random_.below(4); i > 0; --i) all.push_back(settable(numeric(), 2));
  return all;
}

Json DefinitionGenerator::definition() {
  const auto name = made_name();
  return {{"model", random_.chance(50) ? name + "/" + name : name},
          {"vendor", random_.one_of(kVendors)},
          {"description", "Simulated " + name},
          {"exposes", exposes()},
          {"options", options()},
          {"source", random_.chance(20) ? "generated" : "native"},
          {"supports_ota", random_.chance(500)},
          {"version", "0.0.0"}};
}

Json DefinitionGenerator::device_record(std::uint32_t index) {
  const auto address = fmt::format("0x00124b00{:08x}", 0x20000000U + index);
  const bool battery = random_.chance(450);
  const bool ready = !random_.chance(20);
  Json record{{"ieee_address", address},
              {"friendly_name", random_.chance(400) ? address : fmt::format("{} n{}", random_.one_of(kRooms), index)},
              {"type", battery ? "EndDevice" : "Router"},
              {"network_address", 1 + index % 65527},
              {"supported", ready && !random_.chance(10)},
              {"disabled", random_.chance(5)},
              {"interview_state", ready                 ? "SUCCESSFUL"
                                  : random_.chance(500) ? "FAILED"
                                                        : "IN_PROGRESS"},
              {"interviewing", false},
              {"interview_completed", ready},
              {"endpoints",
               {{"1",
                 {{"bindings", Json::array()},
                  {"clusters", {{"input", {"genBasic"}}, {"output", Json::array()}}},
                  {"configured_reportings", Json::array()},
                  {"scenes", Json::array()}}}}}};
  if (ready) record["definition"] = definition();
  if (!ready && random_.chance(500)) record["definition"] = nullptr;
  if (!random_.chance(30)) record["power_source"] = battery ? "Battery" : "Mains (single phase)";
  if (!random_.chance(30)) record["model_id"] = made_name();
  if (!random_.chance(30)) record["manufacturer"] = random_.one_of(kVendors);
  if (random_.chance(100)) record["software_build_id"] = nullptr;
  return record;
}

Json DefinitionGenerator::value_of(const Json& leaf) {
  const auto type = leaf.value("type", "");
  if (type == "binary") return leaf[random_.chance(500) ? "value_on" : "value_off"];
  if (type == "enum") return leaf["values"].empty() ? Json() : random_.one_of(leaf["values"]);
  if (type == "text") return random_.chance(100) ? Json("é\"\n") : Json(random_.one_of(kWords));
  if (type == "list") {
    auto items = Json::array();
    for (auto i = random_.between(1, 3); i > 0; --i) items.push_back(value_of(leaf["item_type"]));
    return items;
  }
  if (type == "composite") {
    auto parts = Json::object();
    for (const auto& part : leaf["features"]) parts[part.value("property", "?")] = value_of(part);
    return parts;
  }
  const double low = leaf.value("value_min", leaf.value("value_max", 100.0) - 100.0);
  const double high = leaf.value("value_max", low + 100.0);
  const double step = leaf.value("value_step", random_.chance(700) ? 1.0 : 0.01);
  const double steps = std::floor((high - low) / step + 1e-9);
  const double value = low + step * static_cast<double>(random_.below(static_cast<std::uint64_t>(steps) + 1));
  const double rounded = std::round(value * 100) / 100;
  return rounded == std::floor(rounded) ? Json(std::llround(rounded)) : Json(rounded);
}

Json DefinitionGenerator::state_of(const Json& exposes) {
  auto state = Json::object();
  for (const auto& leaf : leaves_of(exposes)) {
    if ((access_of(leaf) & 1) == 0) continue;
    state[leaf.value("property", "?")] = random_.chance(20) ? Json() : value_of(leaf);
  }
  state["linkquality"] = random_.below(256);
  return state;
}

}  // namespace rubicon::zigbee_simulator
