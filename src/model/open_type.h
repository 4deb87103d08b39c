#pragma once

#include <string>

#include "model/point.h"
#include "model/type_catalogue.h"

namespace rubicon::model {

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

}  // namespace rubicon::model
