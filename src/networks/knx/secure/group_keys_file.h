#pragma once

#include <string>
#include <string_view>

#include "networks/knx/secure/group_keys.h"
#include "networks/knx/secure/key.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::secure {

inline constexpr std::size_t kMaxGroupKeysBytes = std::size_t{1} << 20U;

/// Keys of groups that were written down without a keyring. One line for each group:
///
///     1/2/7 000102030405060708090a0b0c0d0e0f sender 1.1.5 1.1.6   # a comment
///
/// Without `sender` each device may send. kInvalid with the number of the line; no error holds a key.
Result<GroupKeys> parse_group_keys(std::string_view text);

/// Reads them from a file of at most kMaxGroupKeysBytes, with the errors of read_private_file() too.
Result<GroupKeys> read_group_keys_file(transport::Transports& transports, const std::string& path);

}  // namespace rubicon::networks::knx::secure
