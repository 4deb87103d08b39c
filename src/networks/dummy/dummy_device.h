#pragma once

#include <map>
#include <vector>

#include "networks/dummy/dummy_script.h"

namespace rubicon::networks::dummy {

/// One simulated device: joins, sends keep-alives and readings, and handles commands as its script says.
class DummyDevice {
 public:
  DummyDevice(ScriptedDevice self, network::NetworkHost& host, const bool& line_is_up);

  /// Starts the script; its times count from now.
  void start();
  /// Sends its Join again, for a line that is back.
  void announce();
  Result<void> send(const Message& message);
  /// Leaves, because the configuration no longer names it.
  void retire();
  /// Whether a new configuration leaves it unchanged.
  bool has_script_of(const ScriptedDevice& other) const {
    return script_.digest == other.script->digest && self_.name == other.name;
  }
  /// With all its points.
  network::ListedDevice listed() const { return {self_.address, capabilities()}; }

 private:
  struct PendingCommand {
    Value value;
    Timer timer;
  };

  std::vector<model::Capability> capabilities() const;
  void join();
  void leave();
  void keep_alive();
  void deliver(model::Body body);
  void report(const model::PointId& point, Value value);
  void measure();
  void acknowledge(std::uint64_t request, model::Outcome outcome, std::string text = {});

  Result<void> sample(const model::Sample& sample);
  Result<void> actuate(const model::Actuate& actuate);
  Result<void> set_property(const model::SetProperty& set);
  void execute(std::size_t actuator);

  ScriptedDevice self_;
  const DeviceScript& script_;  ///< in self_
  network::NetworkHost& host_;
  const bool& line_is_up_;
  SteadyTime started_{};
  bool joined_ = false;
  Timer join_timer_, leave_timer_, rejoin_timer_, keep_alive_timer_, sample_timer_;
  std::vector<std::size_t> sampled_;         ///< indexes of script_.sensors
  std::vector<Wave::Chance> chances_;        ///< of the sensors
  std::map<std::size_t, Value> properties_;  ///< those that were set, by index
  Duration period_{};
  std::map<std::size_t, PendingCommand> pending_;  ///< by index of the actuator
  std::map<model::PointId, Value> followers_;      ///< values of sensors that follow an actuator
};

}  // namespace rubicon::networks::dummy
