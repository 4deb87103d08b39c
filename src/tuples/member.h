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

/// The names of all components of engines PEIS and DDS, which never know who asks.
inline constexpr std::string_view kPeisMember = "peis", kLanMember = "lan";

/// Who a component is, as its engine knows: on host the kernel, on mqtt the broker and the realm; on DDS and PEIS
/// nobody knows: there it is always `lan` or `peis`.
struct Member {
  std::string name;
  std::vector<std::string> roles{};
  std::vector<IdRange> ids{};  ///< that its components may use; of nobody known: any
  std::string through{};       ///< the member that handed its message on and says who it is; empty = it was here itself

  /// Whether it is only the wire by which it came. `peis@hall`: by a carrier.
  bool is_unproven() const {
    const auto wire = std::string_view(name).substr(0, name.find('@'));
    return wire == kPeisMember || wire == kLanMember;
  }
  /// As others name it whom it asks to hand something on: with its source.
  std::string name_with_source() const {
    return name.find(':') != name.npos || name == kPeisMember || name == kLanMember ? name : "member:" + name;
  }
  bool may_use(OwnerId id) const {
    return std::any_of(ids.begin(), ids.end(), [id](const IdRange& one) { return one.contains(id); });
  }
  bool has_role(std::string_view role) const { return std::find(roles.begin(), roles.end(), role) != roles.end(); }
  friend bool operator==(const Member&, const Member&) = default;
};

}  // namespace rubicon::tuples
