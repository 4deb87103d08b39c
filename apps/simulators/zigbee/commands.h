#pragma once

#include <string_view>
#include <vector>

#include "apps/simulators/zigbee/bridge_topics.h"
#include "apps/simulators/zigbee/radio.h"
#include "apps/simulators/zigbee/registry.h"

namespace rubicon::zigbee_simulator {

/// What clients ask of devices and groups: set and get (zigbee.md, sections 5 and 7).
class Commands {
 public:
  using Json = nlohmann::json;

  /// All must outlive it.
  Commands(BridgeState& state, Registry& registry, BridgeTopics& topics, Radio& radio, Delays& delays);

  /// An empty property: the payload has all of them.
  void set(std::string_view name, std::string_view property, std::string_view payload);
  void get(std::string_view name, std::string_view property, std::string_view payload);

 private:
  void set_device(RadioDevice& device, const Json& wanted);
  void answer_set(RadioDevice& device, const Json& accepted);
  void show_echo(RadioDevice& device, const Json& echo);
  void do_set(RadioDevice& device, const Json& accepted);
  void set_group(DeviceGroup& group, const Json& wanted);
  void answer_get(RadioDevice& device, const std::vector<std::string>& properties);

  BridgeState& state_;
  Registry& registry_;
  BridgeTopics& topics_;
  Radio& radio_;
  Delays& delays_;
};

}  // namespace rubicon::zigbee_simulator
