#pragma once

#include <optional>
#include <string>

#include "apps/simulators/script.h"
#include "apps/simulators/zigbee/broker_line.h"
#include "apps/simulators/zigbee/script.h"
#include "apps/simulators/zigbee/world.h"

namespace rubicon::zigbee_simulator {

struct SimulatorOptions {
  WorldOptions world;
  transport::MqttOptions broker;
  int devices = 0;    ///< of the built-in models, in turn, besides those of the script
  int generated = 0;  ///< with random definitions
};

/// A Zigbee2MQTT without radio on a broker, with the devices and steps of a script.
class Simulator {
 public:
  /// Scheduler, transports and log must outlive it.
  Simulator(SimulatorOptions options, Script script, Scheduler& scheduler, transport::Transports& transports, Log log);

  /// Makes the devices, and begins to connect. kInvalid for names that a bridge does not permit.
  Result<void> open();
  std::function<void()> connected;  ///< to the broker, for the first time
  World& world() { return world_; }
  BrokerLine& line() { return line_; }

 private:
  Result<RadioDevice*> add(const std::string& model, std::string name);
  DeviceModel model_of(const std::string& name);
  void take(const Step& step);
  void take_of(RadioDevice& device, const Step& step);
  void set_fault(RadioDevice& device, const std::string& word);
  void burst(int count);

  SimulatorOptions options_;
  Script file_;
  Log log_;
  World world_;
  BrokerLine line_;
  DefinitionGenerator generator_;
  std::uint32_t generated_ = 0;
  simulation::ScriptRun<Step> script_;
};

}  // namespace rubicon::zigbee_simulator
