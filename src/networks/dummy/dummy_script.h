#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/message.h"
#include "network/network.h"
#include "networks/dummy/wave.h"

namespace rubicon::networks::dummy {

struct SensorScript {
  std::string id;  ///< as configured; gives the seed of its chance
  model::Capability capability;
  Wave wave;
};

struct ActuatorScript {
  enum class Behaviour { kObey, kIgnore, kFail, kSilent };
  model::Capability capability;
  const Type* type = nullptr;
  Behaviour behaviour = Behaviour::kObey;
  Duration delay{};
  std::optional<model::PointId> sensor;  ///< a sensor that follows the actuator
};

struct PropertyScript {
  model::Capability capability;  ///< `initial` is its value
  const Type* type = nullptr;
};

/// What all devices of an entry of `simulate` share.
struct DeviceScript {
  std::string model, type;
  Duration join{};
  std::optional<Duration> leave, rejoin;
  Duration keep_alive{};
  std::vector<SensorScript> sensors;
  std::vector<ActuatorScript> actuators;
  std::vector<PropertyScript> properties;
  std::size_t digest = 0;  ///< of the entry in the configuration
};

/// One device of an entry.
struct ScriptedDevice {
  std::string address, name;
  std::uint64_t seed = 1;
  std::shared_ptr<const DeviceScript> script;
  Duration first_keep_alive{};  ///< from its join to its first keep-alive; differs within a range to spread the load
};

/// What is simulated. All times count from the first opening of the line.
struct Script {
  std::uint64_t seed = 1;
  std::vector<ScriptedDevice> devices;
  std::optional<Duration> down_at, up_at;
};

/// Reads the network's options; mistakes are added to the reader's errors.
Script read_script(const network::NetworkConfig& config);

}  // namespace rubicon::networks::dummy
