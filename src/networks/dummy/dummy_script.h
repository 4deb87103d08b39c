#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/message.h"
#include "network/network.h"
#include "networks/dummy/wave.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::dummy {

/// The addresses that a key of `simulate` names: `kitchen` one, `room-{1..10000}` those from `room-1` to `room-10000`.
/// Numbers have at least as many digits as the first one if that begins with 0: `{01..12}`.
class DeviceRange {
 public:
  /// kInvalid for two ranges in one key, ends that are not whole numbers, or a first number above the last.
  static Result<DeviceRange> parse(std::string_view key);

  std::size_t count() const { return last_ - first_ + 1; }
  std::string address(std::size_t index) const { return before_ + (is_range_ ? number(index) : "") + after_; }
  /// `text` with `{n}` replaced by the number of that device.
  std::string name(const std::string& text, std::size_t index) const;

 private:
  std::string number(std::size_t index) const;

  std::string before_, after_;
  std::size_t first_ = 0, last_ = 0, digits_ = 0;  ///< digits: the minimum
  bool is_range_ = false;
};

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
