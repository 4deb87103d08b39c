#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "apps/simulators/zigbee/bridge_topics.h"
#include "apps/simulators/zigbee/registry.h"

namespace rubicon::zigbee_simulator {

/// What devices do by themselves, and what the bridge hears of it: reports, silence, and moves that take time.
class Radio {
 public:
  using Json = nlohmann::json;

  /// All must outlive it.
  Radio(const BridgeState& state, Registry& registry, BridgeTopics& topics)
      : state_(state), registry_(registry), topics_(topics), random_(state.options.seed) {}

  /// A device that sleeps woke: what waited for it. May be empty.
  std::function<void(RadioDevice& device, const Json& wanted)> woke;

  /// The value changes on the device itself, which reports it.
  void change(RadioDevice& device, const std::string& property, Json value);
  /// An uncached property such as `action`: one message.
  void act(RadioDevice& device, const std::string& property, const Json& value);
  /// The device measures and reports; what waits for it to wake is sent.
  void report(RadioDevice& device);
  /// The device reports these properties.
  void report(RadioDevice& device, const std::vector<std::string>& properties);
  /// The bridge hears it, and learns nothing.
  void hear(RadioDevice& device);
  /// It was reset and pairs again: announces itself under its address.
  void announce(RadioDevice& device);
  void set_faults(RadioDevice& device, Faults faults);

  /// Begins to report by itself, if it does so.
  void begin(RadioDevice& device);
  /// Moves a cover to its goal, with a report at each step.
  void travel(RadioDevice& device, int goal);
  void stop_travel(const RadioDevice& device) { travels_.erase(device.address()); }
  /// Groups follow what a member reports; each is off when all its members are.
  void follow(const RadioDevice& member);

  /// The device is gone.
  void forget(const std::string& address);
  /// No device reports by itself until begin().
  void stop() { periods_.clear(); }

 private:
  using Timers = std::map<std::string, Timer>;  ///< by address

  void mark(RadioDevice& device, bool online);
  void clear_later(RadioDevice& device, const std::string& property);
  void next_period(const std::string& address);

  const BridgeState& state_;
  Registry& registry_;
  BridgeTopics& topics_;
  Random random_;
  Timers periods_, silences_, clearings_, travels_;
};

}  // namespace rubicon::zigbee_simulator
