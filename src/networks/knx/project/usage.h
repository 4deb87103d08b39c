#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/words.h"
#include "networks/knx/project/installation.h"

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

/// A communication object as the bus knows it, with its flags (communication, read, write, transmit; KNX 3/4/1). What
/// it points to must outlive it.
struct BusObject {
  std::size_t device = 0;
  std::string_view channel;                  ///< the same for objects of a device that belong together; empty = unknown
  const groups::NameWords* words = nullptr;  ///< of its function text: `Switching`, `Switching status`
  const std::vector<dpt::DptId>* types = nullptr;  ///< nullptr = unknown
  bool flags_known = true;                         ///< else it may do anything with its addresses
  bool communicates = false, read = false, write = false, transmit = false;
  std::vector<std::size_t> addresses;  ///< indices in the list; it sends to the first

  bool takes() const { return communicates && write; }
  /// It has a value of its own, which the bus cannot set.
  bool reports() const { return communicates && !write && (read || transmit); }
};

/// Addresses of a function with their roles, as indices in the list.
using Members = std::vector<std::pair<std::size_t, std::string>>;

/// What the project says about the addresses of a list, by index.
struct Usage {
  std::vector<groups::Use> uses;
  std::vector<std::optional<std::size_t>> states;  ///< the address that reports the state of this one
};

/// By functions of the project: an `Info...` or `Current...` role reports what the role with the same end commands.
/// Then by flags: in one channel of one device an object that takes commands and one that reports belong together if
/// they have the same main type and their texts differ only in words such as `status` (words.h). An address that has
/// two states, or is the state of two, has none. How an address is used is unknown where the flags of an object are.
Usage usage_of(const std::vector<BusObject>& objects, const std::vector<groups::GroupEntry>& entries,
               const std::vector<Members>& functions);

}  // namespace rubicon::networks::knx::project
