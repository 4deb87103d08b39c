#include "bridges/bridge.h"

#include <algorithm>

#include "bridges/mqtt/mqtt_bridge.h"
#include "bridges/ros2/ros2_bridge.h"
#include "model/json_members.h"

namespace rubicon::bridges {

namespace {

constexpr BridgeType kTypes[] = {
    {"mqtt", "topics of an MQTT broker, and discovery for Home Assistant", mqtt::make},
    {"ros2", "topics of ROS 2 for robots, and theirs as tuples", ros2::make},
};

}  // namespace

std::span<const BridgeType> bridge_types() {
  return kTypes;
}

const BridgeType* find_bridge_type(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kTypes), std::end(kTypes), [name](const auto& type) { return type.name == name; });
  return found == std::end(kTypes) ? nullptr : found;
}

std::string bridge_type_names() {
  std::string all;
  for (const auto& type : kTypes) all += (all.empty() ? "" : ", ") + std::string(type.name);
  return all;
}

void BridgeStatus::add(std::string_view finding, const std::string& text) {
  reason += (reason.empty() ? "" : "; ") + text;
  findings.emplace_back(finding, text);
}

std::string to_json(const BridgeStatus& status, WallTime since) {
  nlohmann::ordered_json json{
      {"state", status.state}, {"reason", status.reason}, {"peer", status.peer}, {"since", model::seconds_json(since)}};
  for (const auto& [name, value] : status.counters) json[name] = value;
  for (const auto& [finding, text] : status.findings)
    json["findings"].push_back({{"finding", finding}, {"text", text}});
  return model::dump(json);
}

}  // namespace rubicon::bridges
