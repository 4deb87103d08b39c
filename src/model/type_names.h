#pragma once

#include <span>
#include <string>
#include <string_view>

#include "model/point.h"
#include "model/type_catalogue.h"

namespace rubicon::model {

// Names and numbers that a type had before: read wherever a type is written (configurations, command lines, state
// files, recordings, messages of other islands), never written.

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

/// Whether the number is one of open types (open_type()).
constexpr bool is_open(TypeId id) {
  const auto number = static_cast<std::uint16_t>(id);
  return number >= kFirstOpenType && number < kFirstSiteType;
}

/// The name that a type which the catalogue does not know has in keys and descriptions: Capability::type_name with `_`
/// for every character that keys do not allow, and for `-`. A long name is cut and ends in the number of the type.
/// `type17` if the capability names none.
std::string name_in_keys(const Capability& capability);

/// The type of a capability that brings its own (Capability::data): the words of a boolean, and the kind of data, unit
/// and report of all. Bounds and words of an enumeration stay with the point: they limit commands, not readings.
class OpenType {
 public:
  /// The capability has `data`.
  explicit OpenType(const Capability& capability);
  OpenType(const OpenType&) = delete;
  OpenType& operator=(const OpenType&) = delete;

  const Type& type() const { return type_; }

 private:
  std::string name_, unit_, words_;
  Type type_;
};

/// D1.4 writes `rate` in its figure of the tuples and "sampling-rate" in its text (docs/tuple-keys.md): the property is
/// kept as `rate`, and this other name is accepted where users type one.
inline constexpr std::string_view kSamplingRate = "sampling-rate";

/// A key as the proxy keeps it, of one that may name the property `sampling-rate`: a whole key
/// (`proxy.wsn-1.7.property.sampling-rate.command`) or a short name (`wsn-1.7.sampling-rate`, `kitchen.sampling-rate`).
/// Every other key comes back as it is.
std::string without_alias(std::string_view key);

}  // namespace rubicon::model
