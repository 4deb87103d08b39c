#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/time.hpp"

namespace rubicon::tuples {

/// A range of component ids, both ends included.
struct IdRange {
  std::uint32_t first = 0, last = 0;

  bool contains(OwnerId id) const { return first <= number(id) && number(id) <= last; }
  friend bool operator==(const IdRange&, const IdRange&) = default;
};

/// The name of all components of engine PEIS, which never knows who asks.
inline constexpr std::string_view kPeisMember = "peis";

/// Who a component is, as its engine knows: on DDS what its certificate says, on PEIS always `peis`.
struct Member {
  std::string name;
  std::vector<std::string> roles{};
  std::vector<IdRange> ids{};  ///< that its components may use
  std::string serial{};        ///< of its certificate, in upper-case hexadecimal digits; empty = it has none
  WallTime expires{};          ///< end of the certificate; the epoch = never
  std::string through{};       ///< the member that handed its message on and says who it is; empty = it was here itself

  /// As others name it whom it asks to hand something on: with its source.
  std::string name_with_source() const {
    return name.find(':') != name.npos || name == kPeisMember ? name : "member:" + name;
  }
  bool may_use(OwnerId id) const {
    return std::any_of(ids.begin(), ids.end(), [id](const IdRange& one) { return one.contains(id); });
  }
  bool has_role(std::string_view role) const { return std::find(roles.begin(), roles.end(), role) != roles.end(); }
  friend bool operator==(const Member&, const Member&) = default;
};

}  // namespace rubicon::tuples
