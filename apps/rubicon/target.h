#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::cli {

class Session;

/// One tuple, or one of several owners that have it.
struct Target {
  OwnerId owner{};
  std::string key;

  friend bool operator==(const Target&, const Target&) = default;
};

/// A name without wildcards as it was typed.
struct TypedTarget {
  std::optional<OwnerId> owner;
  std::string key;
};
Result<TypedTarget> parse_target(std::string_view text);
/// The same; the owner may be the name of an island.
Result<TypedTarget> parse_target(Session& session, std::string_view text);

/// The pattern that a short name stands for: `living.lamp-1`, `dummy-rooms.living.lamp-1` and
/// `proxy.dummy-rooms.living.actuator.lamp-1`, with `last` (`value`, `command`) behind it. nullopt: it is not a short
/// name.
std::optional<Pattern> long_form(const TypedTarget& typed, std::string_view last);
/// The present tuples that `typed` may mean. If tuples have exactly this key, only those.
std::vector<Target> resolve(Session& session, const TypedTarget& typed, std::string_view last);

/// Prints the candidates; returns kUsage.
int ambiguous(std::string_view typed, const std::vector<Target>& candidates);

}  // namespace rubicon::cli
