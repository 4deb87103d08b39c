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
  std::string id;  ///< as written; its chance follows from it
  model::Capability capability;
  Wave wave;
};

struct ActuatorScript {
  enum class Behaviour { kObey, kIgnore, kFail, kSilent };
  model::Capability capability;
  const Type* type = nullptr;
  Behaviour behaviour = Behaviour::kObey;
  Duration delay{};
  std::optional<model::PointId> sensor;  ///< follows the actuator
};

struct PropertyScript {
  model::Capability capability;  ///< `initial` is its value
  const Type* type = nullptr;
};

/// What all devices of one entry of `simulate` have in common.
struct DeviceScript {
  std::string model, type;
  Duration join{};
  std::optional<Duration> leave, rejoin;
  Duration keep_alive{};
  std::vector<SensorScript> sensors;
  std::vector<ActuatorScript> actuators;
  std::vector<PropertyScript> properties;
  std::size_t digest = 0;  ///< of the entry as it stands in the configuration
};

/// One device: what it shares with others of its range, and what it has alone.
struct ScriptedDevice {
  std::string address, name;
  std::uint64_t seed = 1;
  std::shared_ptr<const DeviceScript> script;
  Duration first_live{};  ///< from its join to its first sign of life: a range does not speak at once
};

/// What the configuration says shall happen. All times count from the first opening of the line.
struct Script {
  std::uint64_t seed = 1;
  std::vector<ScriptedDevice> devices;
  std::optional<Duration> down_at, up_at;
};

/// Reads the network's options; what is wrong is reported to them.
Script read_script(const network::NetworkConfig& config);

}  // namespace rubicon::networks::dummy
