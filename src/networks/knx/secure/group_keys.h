#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "networks/knx/secure/key.h"
#include "networks/knx/wire/address.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::secure {

/// A group address that takes secured telegrams only.
struct GroupKey {
  std::optional<Key> key{};                     ///< nullopt: secured, but its key is not known
  std::set<wire::IndividualAddress> senders{};  ///< whose telegrams are accepted
  /// The same for a line that has one of these addresses.
  std::map<wire::IndividualAddress, std::set<wire::IndividualAddress>> senders_for{};
  /// From which addresses receivers accept telegrams; nullopt: not known, so from each.
  std::optional<std::set<wire::IndividualAddress>> may_send{};
  bool any_sender = false;  ///< telegrams of all others are accepted too

  /// `own`: the address of the line, 0.0.0 = not known.
  bool may_send_from(wire::IndividualAddress own) const { return !may_send || may_send->contains(own); }
  const std::set<wire::IndividualAddress>& senders_to(wire::IndividualAddress own) const {
    const auto found = senders_for.find(own);
    return found == senders_for.end() ? senders : found->second;
  }

  friend bool operator==(const GroupKey&, const GroupKey&) = default;
};

/// What one line needs for Data Secure (knx.md, sections 11 and 12).
struct GroupKeys {
  std::map<wire::GroupAddress, GroupKey> groups;
  /// The last sequence number of a device that is known from elsewhere (keyring); also of our own address.
  std::map<wire::IndividualAddress, std::uint64_t> sequences;

  friend bool operator==(const GroupKeys&, const GroupKeys&) = default;
};

/// Keeps small values across restarts, as NetworkHost::remember() and remembered() do. kUnsupported: nothing is kept.
/// An empty function means the same.
struct GroupStorage {
  /// The value is on the disk when this returns success.
  std::function<Result<void>(std::string_view name, ByteView value)> store;
  std::function<Result<std::optional<Bytes>>(std::string_view name)> stored;
  /// The same as `store` without a wait for the disk: the value survives the end of the process, but a power failure
  /// only after a later call of `store`. Empty: `store` does it.
  std::function<Result<void>(std::string_view name, ByteView value)> store_soon{};
};

/// As LineCallbacks::note: for the log, limited by the callee.
using Note = std::function<void(std::string_view subject, std::string_view text)>;

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
