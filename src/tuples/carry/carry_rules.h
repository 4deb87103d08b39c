#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/key.hpp"

namespace rubicon::tuples::carry {

/// From one engine to another, by their names in the configuration.
struct Way {
  std::string_view from, to;
};

/// Which components and tuples are carried on some ways.
struct CarryRule {
  std::set<OwnerId> ids{};              ///< components, with all their tuples
  std::vector<std::string> patterns{};  ///< keys: those tuples of every component
  std::vector<std::string> from{};      ///< engines where the component is met; empty = any
  std::vector<std::string> to{};        ///< engines where it has a stand-in; empty = any

  bool covers(Way way) const;
  friend bool operator==(const CarryRule&, const CarryRule&) = default;
};

/// What an island carries between its engines.
struct CarryRules {
  std::vector<CarryRule> rules{};
  std::size_t most = 1000;  ///< stand-ins at a time

  bool empty() const { return rules.empty(); }
  bool carries_any_of(OwnerId id, Way way) const;
  /// Patterns of the keys that are carried of this component.
  std::vector<std::string> keys_of(OwnerId id, Way way) const;
  bool carries(OwnerId id, std::string_view key, Way way) const;
  /// Equal for carriers that carry the same between these two engines, in both directions; empty = nothing.
  std::string digest(std::string_view one, std::string_view other) const;

  friend bool operator==(const CarryRules&, const CarryRules&) = default;
};

/// Adds an entry of the configuration: the id of a component, or a pattern of keys without an owner. kInvalid: neither.
/// kDuplicate: it is there already.
Result<void> add_entry(CarryRule& rule, std::string_view text);

/// The pattern of the keys that match both; nullopt = none can.
std::optional<std::string> common_keys(std::string_view one, std::string_view other);

/// What a carrier states in its summary, so that only one of several equal carriers carries: the digest of its rules,
/// by pair of engines (`dds-mqtt`, in alphabetical order).
using Announcement = std::map<std::string, std::string>;

std::string pair_name(std::string_view one, std::string_view other);
/// The summary with the member `carries`; unchanged if it would be too long, or is not an object.
std::string with_announcement(std::string summary, const Announcement& carries);
/// Empty: it carries nothing.
Announcement announcement_of(std::string_view summary);

}  // namespace rubicon::tuples::carry
