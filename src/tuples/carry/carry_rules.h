#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/key.hpp"

namespace rubicon::tuples::carry {

/// What an island carries from one engine to the other.
struct CarryRules {
  std::set<OwnerId> ids;              ///< components, with all their tuples
  std::vector<std::string> patterns;  ///< keys: those tuples of every component
  std::size_t most = 1000;            ///< stand-ins at a time

  bool empty() const { return ids.empty() && patterns.empty(); }
  bool carries_any_of(OwnerId id) const { return !patterns.empty() || ids.contains(id); }
  /// Patterns of the keys that are carried of this component.
  std::vector<std::string> keys_of(OwnerId id) const;
  bool carries(OwnerId id, std::string_view key) const;

  friend bool operator==(const CarryRules&, const CarryRules&) = default;
};

/// Adds an entry of the configuration: the id of a component, or a pattern of keys without an owner. kInvalid: neither.
Result<void> add_entry(CarryRules& rules, std::string_view text);

/// The pattern of the keys that match both; nullopt = none can.
std::optional<std::string> common_keys(std::string_view one, std::string_view other);

}  // namespace rubicon::tuples::carry
