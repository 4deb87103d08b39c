#include "networks/zigbee/device_options.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "base/bytes.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/bridge/json_tree.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

using bridge::JsonObject;
using nlohmann::json;

constexpr std::size_t kMaxTroubled = 100;

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
    if (name != "friendly_name" && values.size() < bridge::kMaxOptions)
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

json device_options(std::string_view id, const std::vector<std::string>& definition, std::string_view info) {
  auto values = configured(id, info);
  auto options = json::array();
  for (const auto& text : definition) {
    bridge::JsonTree tree;
    const auto leaf = tree.parse_object(text, "an option", bridge::kMaxRecordBytes);
    if (leaf) options.push_back(option_json(*leaf));
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
