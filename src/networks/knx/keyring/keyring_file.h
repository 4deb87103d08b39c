#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "networks/knx/wire/address.h"
#include "rubicon/time.hpp"
#include "transport/transports.h"

namespace rubicon::networks::knx::keyring {

constexpr std::size_t kMaxKeyringBytes = std::size_t{16} << 20U;

/// The content of a keyring as ETS exports it (.knxkeys; knx.md, sections 12 and 21.6), with its keys and passwords
/// still encrypted: what can be known without the password.
struct KeyringFile {
  /// AES-128-CBC: one block for a key, at least one for a password; empty = not in the file.
  using Encrypted = Bytes;

  struct Backbone {
    std::string multicast;  ///< IPv4 address
    Duration latency = std::chrono::seconds(2);
    Encrypted key;  ///< empty: the backbone is not secured, as ETS 6 writes it in each project
  };
  struct Group {
    wire::GroupAddress address{};
    std::vector<wire::IndividualAddress> senders;
  };
  struct Interface {
    std::string type;                   ///< Tunneling, USB, Backbone
    wire::IndividualAddress address{};  ///< of the tunnel; 0.0.0 = none
    wire::IndividualAddress host{};     ///< of the server; 0.0.0 = none, as for USB
    std::optional<std::uint8_t> user;   ///< 1 to 127
    Encrypted password, authentication;
    std::vector<Group> groups;  ///< groups that the tunnel takes part in
  };
  struct GroupKey {
    wire::GroupAddress address{};
    Encrypted key;
  };
  struct Device {
    wire::IndividualAddress address{};
    Encrypted tool_key, management_password, authentication;
    std::optional<std::uint64_t> sequence;
  };

  std::string project, created_by;
  std::string created;  ///< its text is part of the encryption
  Bytes signature;      ///< 16 bytes
  Bytes signed_bytes;   ///< what the signature covers, but for the key at the end
  std::optional<Backbone> backbone;
  std::vector<Interface> interfaces;
  std::vector<GroupKey> group_keys;
  std::vector<Device> devices;
};

/// Reads the XML of a keyring; elements without a meaning here only count for the signature. kInvalid or kRefused with
/// the line: not well-formed, a DOCTYPE, not a keyring, a value that cannot be read; kOutOfRange: too large.
Result<KeyringFile> parse_keyring(std::string_view text);

/// The same for a file on disk, with its name before the errors. Blocks: for start-up and tools.
Result<KeyringFile> read_keyring(transport::Transports& transports, const std::string& path);

}  // namespace rubicon::networks::knx::keyring
