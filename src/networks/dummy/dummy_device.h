#pragma once

#include <map>
#include <vector>

#include "networks/dummy/dummy_script.h"

namespace rubicon::networks::dummy {

/// One simulated device: joins, lives, measures what is asked for, and does with commands what its script says.
class DummyDevice {
 public:
  DummyDevice(ScriptedDevice self, network::NetworkHost& host, const bool& line_is_up);

  /// The script begins; times count from here.
  void start();
  /// The line is back: says again what it is.
  void greet();
  Result<void> send(const Message& message);
  /// The configuration no longer names it.
  void retire();
  /// The configuration says the same of it.
  bool plays(const ScriptedDevice& other) const {
    return script_.digest == other.script->digest && self_.name == other.name;
  }
  /// With all its points.
  network::ListedDevice listed() const { return {self_.address, capabilities()}; }

 private:
  struct Job {
    std::size_t actuator;
    Value value;
    Timer timer;
  };

  std::vector<model::Capability> capabilities() const;
  void join();
  void leave();
  void live();
  void tell(model::Body body);
  void report(const model::PointId& point, Value value);
  void measure();
  void acknowledge(std::uint64_t request, model::Outcome outcome, std::string text = {});

  Result<void> sample(const model::Sample& sample);
  Result<void> actuate(const model::Actuate& actuate);
  Result<void> set_property(const model::SetProperty& set);
  void obey(std::size_t actuator);

  ScriptedDevice self_;
  const DeviceScript& script_;  ///< in self_
  network::NetworkHost& host_;
  const bool& line_is_up_;
  SteadyTime began_{};
  bool joined_ = false;
  Timer join_timer_, leave_timer_, rejoin_timer_, live_timer_, sample_timer_;
  std::vector<std::size_t> sampled_;   ///< places in script_.sensors
  std::vector<Wave::Chance> chances_;  ///< of the sensors
  std::map<std::size_t, Value> set_;   ///< properties that were set, by their places
  Duration period_{};
  std::map<std::size_t, Job> jobs_;           ///< by actuator: what it is about to do
  std::map<model::PointId, Value> followed_;  ///< sensors that show what an actuator did
};

}  // namespace rubicon::networks::dummy
