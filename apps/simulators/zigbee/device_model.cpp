#include "apps/simulators/zigbee/device_model.h"

#include <algorithm>

#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::zigbee_simulator {

namespace {

using Json = nlohmann::json;

constexpr auto kLinkQuality = R"json({"type":"numeric","name":"linkquality","property":"linkquality","access":1,
  "category":"diagnostic","label":"Linkquality","description":"Link quality (signal strength)","unit":"lqi",
  "value_min":0,"value_max":255})json";

Json list_of(const Json& tree, const char* name) {
  const auto found = tree.find(name);
  return found == tree.end() ? Json::array() : *found;
}

Json object_of(const Json& tree, const char* name) {
  const auto found = tree.find(name);
  return found == tree.end() ? Json::object() : *found;
}

Json endpoint(const Json& model, bool first) {
  auto reportings = Json::array(), bindings = Json::array();
  std::set<std::string> bound;
  for (const auto& one : first ? list_of(model, "reporting") : Json::array()) {
    reportings.push_back({{"cluster", one[0]},
                          {"attribute", one[1]},
                          {"minimum_report_interval", one[2]},
                          {"maximum_report_interval", one[3]},
                          {"reportable_change", one[4]}});
    if (bound.insert(one[0]).second)
      bindings.push_back({{"cluster", one[0]},
                          {"target", {{"endpoint", 1}, {"ieee_address", "0x00124b00deadbeef"}, {"type", "endpoint"}}}});
  }
  return {{"bindings", bindings},
          {"clusters", {{"input", list_of(model, "input")}, {"output", list_of(model, "output")}}},
          {"configured_reportings", reportings},
          {"scenes", Json::array()}};
}

Json endpoints(const Json& model) {
  const auto names = list_of(model, "endpoints");
  auto all = Json::object();
  for (std::size_t i = 0; i < std::max<std::size_t>(names.size(), 1); ++i) {
    auto& made = all[std::to_string(i + 1)] = endpoint(model, i == 0);
    if (i < names.size()) made["name"] = names[i];
  }
  return all;
}

void add_leaves(DeviceModel& model) {
  for (auto& leaf : leaves_of(model.definition["exposes"])) {
    const auto property = leaf.value("property", "");
    model.leaves[property].push_back(std::move(leaf));
  }
}

int access_bits(const Json& leaf) {
  const auto found = leaf.find("access");
  return found != leaf.end() && found->is_number_integer() ? found->get<int>() : 0;
}

bool accepts_number(const Json& leaf, const Json& value) {
  if (!value.is_number()) return false;
  const auto number = value.get<double>();
  for (const auto& preset : list_of(leaf, "presets")) {
    if (preset["value"] == value) return true;
  }
  return number >= leaf.value("value_min", number) && number <= leaf.value("value_max", number);
}

}  // namespace

bool is_published(const Json& leaf) {
  return (access_bits(leaf) & 1) != 0;
}
bool is_settable(const Json& leaf) {
  return (access_bits(leaf) & 2) != 0;
}
bool is_gettable(const Json& leaf) {
  return (access_bits(leaf) & 4) != 0;
}

bool accepts(const Json& leaf, const Json& value) {
  const auto type = leaf.value("type", "");
  if (type == "numeric") return accepts_number(leaf, value);
  if (type == "binary")
    return value == leaf["value_on"] || value == leaf["value_off"] || value == list_of(leaf, "value_toggle");
  if (type == "text") return value.is_string();
  if (type == "list") return value.is_array();
  if (type == "composite") return value.is_object();
  const auto words = list_of(leaf, "values");
  return std::find(words.begin(), words.end(), value) != words.end();
}

DeviceModel read_model(std::string_view json) {
  const auto tree = model::object_of(json);
  DeviceModel model;
  auto exposes = list_of(tree, "exposes");
  exposes.push_back(model::parse_json(kLinkQuality));
  model.definition = {{"model", tree["model"]},
                      {"vendor", tree["vendor"]},
                      {"description", tree["description"]},
                      {"exposes", std::move(exposes)},
                      {"options", list_of(tree, "options")},
                      {"source", "native"},
                      {"supports_ota", model::flag_of(tree, "supports_ota")},
                      {"version", "0.0.0"}};
  model.manufacturer = model::text_of(tree, "manufacturer");
  model.model_id = model::text_of(tree, "model_id");
  model.battery = model::flag_of(tree, "battery");
  model.sleeps = model.battery && !model::flag_of(tree, "awake");
  model.endpoints = endpoints(tree);
  const auto clusters = object_of(tree, "cluster"), walks = object_of(tree, "walk");
  for (const auto& [property, cluster] : clusters.items()) model.cluster[property] = cluster;
  for (const auto& [property, walk] : walks.items()) model.walk[property] = walk;
  model.values = object_of(tree, "values");
  model.known = object_of(tree, "known");
  for (auto& property : model::texts_of(tree, "no_echo")) model.no_echo.insert(std::move(property));
  if (const auto clears = list_of(tree, "clears"); clears.size() == 3)
    model.clears = {clears[0], clears[1], std::chrono::seconds(clears[2].get<int>())};
  add_leaves(model);
  return model;
}

DeviceModel make_model(DefinitionGenerator& generator, std::uint32_t index) {
  auto record = generator.device_record(index);
  DeviceModel model;
  model.definition = record.value("definition", Json());
  if (!model.definition.is_object())
    model.definition = Json{{"exposes", Json::array()}, {"model", "none"}, {"vendor", "none"}};
  model.manufacturer = model::text_of(record, "manufacturer");
  model.model_id = model::text_of(record, "model_id");
  model.battery = record["type"] == "EndDevice";
  model.sleeps = model.battery;
  model.endpoints = record["endpoints"];
  model.values = generator.state_of(model.definition["exposes"]);
  model.values.erase("linkquality");
  model.known = Json::object();
  add_leaves(model);
  for (const auto& [property, leaves] : model.leaves) {
    const auto& leaf = leaves.front();
    if (leaf["type"] != "numeric" || is_settable(leaf) || !is_published(leaf)) continue;
    const double low = leaf.value("value_min", 0.0);
    const double high = std::max(low, leaf.value("value_max", low + 100));
    model.walk[property] = {low, high, (high - low) / 10};
  }
  return model;
}

}  // namespace rubicon::zigbee_simulator
