#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/point.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/scenes.h"
#include "networks/knx/wire/address.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx::groups {

/// When the value of a point is read from the bus (knx.md, section 8).
struct ReadRule {
  enum class When : std::uint8_t { kDemand, kInit, kExpire, kEvery, kNever };
  When when = When::kDemand;  ///< kDemand: for the first subscriber and after a reconnect
  Duration period{};          ///< of expire and every
  friend bool operator==(const ReadRule&, const ReadRule&) = default;
};

/// One sensor or actuator, with one or two group addresses.
struct GroupPoint {
  wire::GroupAddress address{};  ///< receives the commands of an actuator, reports the values of a sensor
  std::optional<wire::GroupAddress>
      state{};                               ///< reports the state of an actuator; without one its commands end assumed
  std::vector<wire::GroupAddress> listen{};  ///< further addresses that report its value
  std::optional<dpt::DptId> dpt{};           ///< nullopt: values are bytes in hex
  Kind kind = Kind::kSensor;
  std::string device{};               ///< id of its device; empty = a device of its own, named after the address
  std::string device_name{};          ///< for display
  std::string instance = "1";         ///< follows the type in keys: `switch-1`, `switch-ceiling`
  std::string name{}, description{};  ///< for display
  std::string state_name{};           ///< of its state address, for display
  std::string main_group{}, middle_group{};
  std::string room{};  ///< `First floor / Kitchen`
  ReadRule read{};
  std::optional<SceneNames> scenes{};  ///< of 17.001 and 18.001: values are names and numbers from 1

  friend bool operator==(const GroupPoint&, const GroupPoint&) = default;
};

}  // namespace rubicon::networks::knx::groups
