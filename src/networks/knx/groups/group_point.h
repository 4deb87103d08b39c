#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/point.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/wire/address.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx::groups {

/// When the value of a point is asked from the bus (knx.md, section 8).
struct ReadRule {
  enum class When : std::uint8_t { kDemand, kInit, kExpire, kEvery, kNever };
  When when = When::kDemand;  ///< demand: when the first subscriber comes, and again as he wishes
  Duration period{};          ///< of expire and every
  friend bool operator==(const ReadRule&, const ReadRule&) = default;
};

/// One sensor or actuator: what one or two group addresses mean together.
struct GroupPoint {
  wire::GroupAddress address{};               ///< an actuator's commands go here; a sensor's values come from here
  std::optional<wire::GroupAddress> state{};  ///< where an actuator reports; none: its commands end assumed
  std::vector<wire::GroupAddress> listen{};   ///< more addresses its value is heard on
  std::optional<dpt::DptId> dpt{};            ///< none: values are bytes in hex
  Kind kind = Kind::kSensor;
  std::string device{};               ///< id of its device; empty = one of its own, called after the address
  std::string device_name{};          ///< for people
  std::string instance = "1";         ///< behind the type in keys: `switch-1`, `switch-ceiling`
  std::string name{}, description{};  ///< for people
  std::string main_group{}, middle_group{};
  ReadRule read{};

  friend bool operator==(const GroupPoint&, const GroupPoint&) = default;
};

}  // namespace rubicon::networks::knx::groups
