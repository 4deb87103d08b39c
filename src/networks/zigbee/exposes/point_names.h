#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "networks/zigbee/exposes/mapping.h"

namespace rubicon::networks::zigbee::exposes {

/// The property without the endpoint at its end; the leaf's name where the two mean the same (`color` of `color_xy`,
/// `fan_mode` of `mode` in a fan).
std::string_view own_property(const Leaf& leaf);
/// The type name of a leaf without a type of the catalogue: its name. One that the catalogue has for something else
/// gets the form of the leaf at its end: `mode_enum`.
std::string open_name(const Leaf& leaf, const TypeCatalogue& types);
/// The part of an open type's instance besides the endpoint: the property, where it is not the name.
std::string open_tag(const Leaf& leaf);

/// Gives the points of one device their ids; none comes twice, neither as PointId nor as part of a key.
class PointNames {
 public:
  /// The number of an open type of this device; where another name has it, the next free one.
  TypeId open_type_of(const std::string& name);
  /// Sets the instance. Called once for each point, in their order; kind and type are set. A property of an endpoint
  /// waits for name_properties().
  void name(const Leaf& leaf, std::string_view tag, Capability& capability);
  /// `leaves` are those of the points, in the same order.
  void name_properties(const std::vector<Leaf>& leaves, std::vector<MappedPoint>& points);
  /// How many ids were tried so far: at most four for each point, whatever the leaves are called.
  std::size_t tries() const { return tries_; }

 private:
  void set_unique(const Leaf& leaf, std::string instance, std::size_t limit, Capability& capability);
  bool take(const std::string& id);

  std::map<std::string, TypeId> open_;
  std::set<TypeId> numbers_;
  std::set<std::string> taken_;
  std::map<std::string, int> last_numbers_;  ///< the number at the end of the newest id with this beginning
  std::size_t tries_ = 0;
  std::vector<std::string> tags_;
};

}  // namespace rubicon::networks::zigbee::exposes
