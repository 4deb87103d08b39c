#include "bridges/bridge.h"

#include <algorithm>

#include "bridges/mqtt/mqtt_bridge.h"
#include "model/json_members.h"

namespace rubicon::bridges {

namespace {

constexpr BridgeType kTypes[] = {
    {"mqtt", "topics of an MQTT broker, and discovery for Home Assistant", mqtt::make},
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

std::string to_json(const BridgeStatus& status, WallTime since) {
  nlohmann::ordered_json json{
      {"state", status.state}, {"reason", status.reason}, {"peer", status.peer}, {"since", model::seconds_json(since)}};
  for (const auto& [name, value] : status.counters) json[name] = value;
  return model::dump(json);
}

}  // namespace rubicon::bridges
