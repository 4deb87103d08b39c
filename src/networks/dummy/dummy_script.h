#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/message.h"
#include "network/network.h"
#include "networks/dummy/wave.h"

namespace rubicon::networks::dummy {

struct SensorScript {
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

struct DeviceScript {
  std::string address, name, model, type;
  Duration join{};
  std::optional<Duration> leave, rejoin;
  Duration keep_alive{};
  std::vector<SensorScript> sensors;
  std::vector<ActuatorScript> actuators;
  std::vector<PropertyScript> properties;
  ConfigNode written;  ///< as it stands in the configuration
};

/// What the configuration says shall happen. All times count from the first opening of the line.
struct Script {
  std::uint64_t seed = 1;
  std::vector<DeviceScript> devices;
  std::optional<Duration> down_at, up_at;
};

/// Reads the network's options; what is wrong is reported to them.
Script read_script(const network::NetworkConfig& config);

}  // namespace rubicon::networks::dummy
