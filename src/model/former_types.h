#pragma once

#include <span>
#include <string>
#include <string_view>

#include "model/point.h"

/// Names and numbers that a type had before: read wherever a type is written (configurations, command lines, state
/// files, recordings, messages of other islands), never written.
namespace rubicon::model {

struct FormerType {
  TypeId id;              ///< the former number
  std::string_view name;  ///< the former name
  TypeId now;
  std::string_view called;  ///< the name of `now`
};
std::span<const FormerType> former_types();

/// The number or name of today; what was never another one stays as it is.
TypeId current_type(TypeId id);
std::string_view current_type(std::string_view name);

/// `illuminance-window` -> `light-window`: the part of the keys of a sensor or actuator.
std::string current_id(std::string_view id);

/// With its type of today; of a property, also the id of the sensor or actuator it belongs to.
PointId current_point(PointId point);

/// A whole key (`proxy.*.*.sensor.illuminance-1.value`) or a short one (`living.illuminance-1`). Only the part behind
/// `sensor`, `actuator` or `property` and the last one are looked at.
std::string current_key(std::string_view key);

}  // namespace rubicon::model
