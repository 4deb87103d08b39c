#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>

#include "apps/simulators/zigbee/registry.h"
#include "base/scheduler.h"
#include "transport/mqtt.h"

namespace rubicon::zigbee_simulator {

struct WorldOptions {
  std::string base = "zigbee2mqtt";
  std::string version = "2.14.1";
  std::string last_seen = "ISO_8601";  ///< advanced.last_seen: `disable`, `ISO_8601`, `ISO_8601_local`, `epoch`
  std::string output = "json";         ///< advanced.output, as `bridge/info` says; states are always JSON
  bool availability = true;
  bool optimistic = true;  ///< false: device_options.optimistic
  bool nulls = false;      ///< properties that were not reported yet are null instead of absent
  bool permit_join = false;
  Duration every{};  ///< each device reports what it measures so often; 0 = never by itself
  std::uint64_t seed = 1;
};

struct BridgeCounters {
  std::uint64_t published = 0, sets = 0, gets = 0, requests = 0;
  std::uint64_t rejected = 0;  ///< sets and gets that the bridge sends to no device
};

/// What the parts of a bridge share.
struct BridgeState {
  WorldOptions options;
  Scheduler& scheduler;
  BridgeCounters counters{};
  bool runs = false, restart_required = false;
  SteadyTime began{}, joining_until{};
  WallTime joining_end{};

  bool joining() const { return joining_until > scheduler.now(); }
};

/// What a bridge publishes: each of its messages, and the topics that are its own.
class BridgeTopics {
 public:
  using Json = nlohmann::json;
  using Publish = std::function<void(transport::MqttPublication)>;

  /// All must outlive it.
  BridgeTopics(BridgeState& state, const Registry& registry) : state_(state), registry_(registry) {}

  /// Where messages go while there is a connection; empty = nowhere.
  Publish publish;
  /// Whether it publishes there: a message is not a command.
  bool is_own(std::string_view topic) const { return own_.contains(topic); }
  /// The device or group with this name is no longer there.
  void forget(const std::string& name);

  /// A message of the bridge with any payload.
  void say(const std::string& topic, std::string payload, bool retain = false);
  void info();
  /// The list, without those of these addresses.
  void devices(const std::set<std::string>& without = {});
  void groups();
  void health();
  void event(std::string_view type, const RadioDevice& device, Json more = Json::object());
  void left(const std::string& name, const std::string& address);
  void state(const RadioDevice& device, const Json& more = Json::object());
  void availability(const RadioDevice& device);
  void group(const DeviceGroup& group);
  void group_availability(const DeviceGroup& group);

 private:
  BridgeState& state_;
  const Registry& registry_;
  std::set<std::string, std::less<>> own_;
};

}  // namespace rubicon::zigbee_simulator
