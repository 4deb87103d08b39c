#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::project {

/// Of an object and of an address at most this many different types count.
inline constexpr std::size_t kMaxTypes = 64;

/// Adds a type that is not there yet.
void add_type(std::vector<dpt::DptId>& types, dpt::DptId type);

/// The types of a communication object: all that are stated (`DPST-9-1 DPST-9-2`; of an unknown sub type the main
/// type, unknown main types not at all), else the main type that its size gives (`1 Bit`, `2 Bit`, `4 Bit`; larger
/// sizes fit several). knx.md, section 21.9.
std::vector<dpt::DptId> object_types(std::string_view types, std::string_view size);

/// The type of a group address.
struct ChosenType {
  std::optional<dpt::DptId> type;
  std::string change;  ///< why its objects give only a main type, or none; empty = nothing to report
};

/// Its own type with a sub type goes before; a main type alone is made more exact by the objects of the same main type.
/// Objects that differ in the sub type give the main type, objects that differ in the main type none (knx.md, section
/// 13.4).
ChosenType type_of(std::optional<dpt::DptId> own, const std::vector<dpt::DptId>& of_objects);

}  // namespace rubicon::networks::knx::project
