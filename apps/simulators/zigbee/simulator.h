#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>

#include "apps/simulators/script.h"
#include "apps/simulators/zigbee/script.h"
#include "apps/simulators/zigbee/world.h"
#include "transport/transports.h"

namespace rubicon::zigbee_simulator {

/// The connection of a World to a broker: connects, and again after each failure, with the will of a bridge. The world
/// starts with the first connection. While there is none, its messages are lost, as a real bridge loses them.
class BrokerLine {
 public:
  /// All must outlive it. `options`: address and user; the will is set here.
  BrokerLine(World& world, transport::MqttOptions options, Scheduler& scheduler, transport::Transports& transports,
             Log log);
  ~BrokerLine();
  BrokerLine(const BrokerLine&) = delete;
  BrokerLine& operator=(const BrokerLine&) = delete;

  /// Begins to connect. kInvalid for options that no broker can accept.
  Result<void> open();
  std::function<void()> started;  ///< after the first connection, once the world has started
  bool connected() const { return connected_; }
  std::uint64_t lost() const { return lost_; }

 private:
  void on_connected();
  void failed(const Error& why);
  void listen();
  void named(const std::string& name, bool used);
  void send(transport::MqttPublication publication);

  World& world_;
  transport::MqttOptions options_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  Log log_;
  std::unique_ptr<transport::MqttLine> line_;
  std::set<std::string> names_;
  bool connected_ = false, had_started_ = false;
  std::string last_error_;
  std::uint64_t lost_ = 0;  ///< messages that were not sent
  Timer again_;
};

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

/// The program zigbee-simulator: reads its command line and runs until a signal ends it. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::zigbee_simulator
