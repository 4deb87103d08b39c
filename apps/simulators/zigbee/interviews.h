#pragma once

#include <string>
#include <vector>

#include "apps/simulators/zigbee/world.h"

namespace rubicon::zigbee_simulator {

/// The pairing of devices: they wait until joining is permitted, and their interviews send the recorded messages in
/// the recorded order.
class Interviews {
 public:
  explicit Interviews(World& world) : world_(world) {}

  /// The device pairs now if joining is permitted, else it waits.
  void add(RadioDevice& device, bool fails);
  /// Joining is permitted: all that wait begin.
  void open();
  void forget(const std::string& address);
  /// The interview of a known device runs again.
  void repeat(RadioDevice& device);

 private:
  struct Candidate {
    std::string address;
    bool fails = false;
  };

  void begin(RadioDevice& device, bool fails);
  void ask(RadioDevice& device, bool fails, int question);
  void succeed(RadioDevice& device);
  void fail_now(RadioDevice& device);
  void configure(RadioDevice& device);

  World& world_;
  std::vector<Candidate> waiting_;
};

}  // namespace rubicon::zigbee_simulator
