#pragma once

#include <string_view>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::trust::site {

inline constexpr std::size_t kLongestUser = 64;  ///< bytes; ub-common-name of RFC 5280

/// A name of a member of the realm of brokers, which is the MQTT user and a level of topics: 1..64 letters, digits,
/// `-`,
/// `_`, `.`, the first one a letter or digit. kInvalid; the text says why: characters that mean something in topics,
/// in access lists, or where one member vouches for another, and names that mean something else.
Result<void> check_user_name(std::string_view name);
/// kInvalid: a name `island-<id>` for a member that does not get this island.
Result<void> check_island_of(std::string_view name, const std::vector<OwnerId>& islands);

}  // namespace rubicon::trust::site
