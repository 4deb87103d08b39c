#pragma once

#include <string_view>

#include "networks/zigbee/exposes/mapping.h"
#include "networks/zigbee/exposes/type_table.h"
#include "networks/zigbee/exposes/units.h"

// How the values of a leaf become values of a point: parts of map_leaves().
namespace rubicon::networks::zigbee::exposes {

/// Whether the bounds of a numeric leaf, where it has them, are values of the type.
bool is_within_type(const Leaf& leaf, const LeafUnit& unit, const TypeRow& row, const Type& type);
/// The coding of a leaf as a type of the catalogue, and the bounds and words of its capability.
void code_as_type(const Leaf& leaf, const LeafUnit& unit, const TypeRow& row, const Type& type, MappedPoint& point);
/// The same as an open type: with its own unit, words and kind of data.
void code_as_open(const Leaf& leaf, const LeafUnit& unit, MappedPoint& point);

}  // namespace rubicon::networks::zigbee::exposes
