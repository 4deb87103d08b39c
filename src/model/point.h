#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/type_catalogue.h"
#include "model/words.h"
#include "rubicon/time.hpp"

namespace rubicon::model {

/// One sensor, actuator or property of a device: kind, type and instance, always all three. The instance is what
/// follows the `-` in keys (`1`, `window`); it never shifts when another is added. A property has an empty
/// instance when it belongs to the device; else the id of the sensor or actuator it belongs to (`light-1`).
struct PointId {
  Kind kind = Kind::kSensor;
  TypeId type{};
  std::string instance;

  friend bool operator==(const PointId&, const PointId&) = default;
  friend auto operator<=>(const PointId&, const PointId&) = default;
};

/// What a device says it can do at one point. Empty fields mean: as the type says.
struct Capability {
  PointId point;
  std::string type_name;  ///< needed where the catalogue does not know point.type (a foreign or newer peer's type)
  Access access = Access::kRead;
  std::string unit;
  std::optional<double> minimum;
  std::optional<double> maximum;
  /// Of an enumeration or a set of bits; sorted by value, none empty. Empty: those of the type. Commands must be
  /// one of them; a number that has no word is a command only where the point has bounds.
  std::vector<Word> words;
  /// Longest normal silence of this point; zero = never stale (reports only changes). Absent: the proxy's rule.
  std::optional<Duration> deadline;
  /// False for an actuator that never reports its state: a command then ends assumed, not confirmed.
  bool reports = true;
  /// An actuator whose state must be requested: Sample names it like a sensor.
  bool sampled = false;
  /// Value a network knows already at the join (a property's configured value); monostate = none.
  Value initial;
  // Of an open type only, which the catalogue does not know (open_type()).
  std::optional<DataType> data{};  ///< absent: numbers and texts as they come
  Report report = Report::kState;

  friend bool operator==(const Capability&, const Capability&) = default;
};

}  // namespace rubicon::model

namespace rubicon {
using model::Access;
using model::Capability;
using model::PointId;
}  // namespace rubicon
