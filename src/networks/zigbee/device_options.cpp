#include "networks/zigbee/device_options.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "base/bytes.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "networks/zigbee/bridge/json_tree.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

using bridge::JsonObject;
using nlohmann::json;

constexpr std::size_t kMaxList = std::size_t{16} << 20;
constexpr std::size_t kMaxOptions = 200, kMaxTroubled = 100;

json parsed(std::string_view text) {
  auto tree = model::parse_json(text);
  return tree.is_discarded() ? json() : tree;
}

/// The options that the configuration of the bridge has for the device; our own text members go before it.
std::map<std::string, json> configured(std::string_view id, std::string_view info) {
  std::map<std::string, json> values;
  bridge::JsonTree tree;
  const auto root = tree.parse_object(info, "bridge/info", bridge::kMaxMessageBytes);
  if (!root) return values;
  const auto config = bridge::object_at(*root, "config");
  const auto devices = config ? bridge::object_at(*config, id.starts_with("0x") ? "devices" : "groups") : std::nullopt;
  const auto own = devices ? bridge::object_at(*devices, id) : std::nullopt;
  if (!own) return values;
  for (const auto& [name, value] : *own) {
    if (name != "friendly_name" && values.size() < kMaxOptions)
      values.emplace(std::string(name), parsed(simdjson::to_string(value)));
  }
  return values;
}

json option_json(const JsonObject& leaf) {
  json out{{"name", bridge::text_at(leaf, "property")}};
  if (out["name"] == "") out["name"] = bridge::text_at(leaf, "name");
  for (const auto* member : {"description", "unit"}) {
    if (auto text = bridge::text_at(leaf, member); !text.empty()) out[member] = std::move(text);
  }
  for (const auto& [from, to] : {std::pair("value_min", "minimum"), {"value_max", "maximum"}, {"values", "values"}}) {
    if (const auto text = bridge::json_at(leaf, from); !text.empty()) out[to] = parsed(text);
  }
  if (bridge::text_at(leaf, "type") == "binary")
    out["values"] = {parsed(bridge::json_at(leaf, "value_on")), parsed(bridge::json_at(leaf, "value_off"))};
  return out;
}

}  // namespace

Result<json> device_options(std::string_view id, std::string_view list, std::string_view info) {
  auto values = configured(id, info);
  auto options = json::array();
  if (id.starts_with("0x")) {
    bridge::JsonTree tree;
    const auto root = tree.parse(list, "bridge/devices", kMaxList);
    if (!root) return fail(root.error());
    simdjson::dom::array records;
    if (root->get(records) != simdjson::SUCCESS) return fail(ErrorCode::kInvalid, "bridge/devices is not a list");
    bool found = false;
    for (const auto& element : records) {
      JsonObject record;
      if (element.get(record) != simdjson::SUCCESS || bridge::text_at(record, "ieee_address") != id) continue;
      found = true;
      const auto definition = bridge::object_at(record, "definition");
      const auto leaves = definition ? bridge::array_at(*definition, "options") : std::nullopt;
      if (!leaves) break;
      for (const auto& one : *leaves) {
        JsonObject leaf;
        if (one.get(leaf) == simdjson::SUCCESS && options.size() < kMaxOptions) options.push_back(option_json(leaf));
      }
    }
    if (!found) return fail(ErrorCode::kNotFound, fmt::format("the list of devices has no {}", model::quoted(id)));
  }
  for (auto& option : options) {
    const auto value = values.find(option["name"].get<std::string>());
    if (value == values.end()) continue;
    option["value"] = std::move(value->second);
    values.erase(value);
  }
  for (auto& [name, value] : values) options.push_back({{"name", name}, {"value", std::move(value)}});
  return json{{"options", std::move(options)}};
}

json health_json(const bridge::BridgeHealth& health) {
  auto troubled = json::array();
  for (const auto& [address, device] : health.devices) {
    if ((device.leaves == 0 && device.address_changes == 0) || troubled.size() >= kMaxTroubled) continue;
    troubled.push_back({{"address", address}, {"leaves", device.leaves}, {"address_changes", device.address_changes}});
  }
  return {{"time", base::to_seconds(health.time)},
          {"load", health.load},
          {"host_memory_percent", health.host_memory_percent},
          {"memory_mb", health.memory_mb},
          {"uptime_seconds", health.uptime_seconds},
          {"mqtt_connected", health.mqtt_connected},
          {"mqtt_queued", health.mqtt_queued},
          {"mqtt_published", health.mqtt_published},
          {"mqtt_received", health.mqtt_received},
          {"devices", std::move(troubled)}};
}

}  // namespace rubicon::networks::zigbee
