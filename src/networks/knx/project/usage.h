#pragma once

#include <optional>
#include <string>
#include <vector>

#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/words.h"
#include "networks/knx/project/installation.h"

namespace rubicon::networks::knx::project {

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

/// What is found out about the addresses of a list, by index.
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
