#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "network/network.h"
#include "networks/knx/keyring/keyring.h"
#include "networks/knx/knx_line.h"
#include "networks/knx/secure/group_keys.h"

namespace rubicon::networks::knx {

/// What the configuration says of KNX Secure. Passwords are not keys yet: derive_access() does that.
struct SecureOptions {
  /// The connection to the interface. kRequire: secure or not at all; kAllow: secure where there are keys for it;
  /// kOff: plain. Secured groups take and get secured telegrams only, whatever this says.
  enum class Policy : std::uint8_t { kRequire, kAllow, kOff };

  struct KeyringSource {
    std::string path;
    keyring::KeyringFile file;
    secure::Secret password;
    std::string password_path{};                      ///< empty: of the environment
    std::optional<wire::IndividualAddress> server{};  ///< the interface, if the keyring has several
    std::vector<wire::IndividualAddress> servers{};   ///< one for each of several hosts; empty = `server` has all
  };
  /// Of a tunnel without a keyring.
  struct User {
    std::uint8_t number = 2;
    secure::Secret password;
    std::optional<secure::Secret> device_password{};  ///< nullopt: the interface is not verified
  };
  /// Of routing without a keyring.
  struct Backbone {
    secure::Key key;
    Duration latency = std::chrono::seconds(2);
  };

  /// Keys of single groups, in addition to the keys of a keyring.
  struct GroupKeysSource {
    std::string path;
    secure::GroupKeys keys;
  };

  Policy policy = Policy::kAllow;
  std::optional<KeyringSource> keyring;
  std::optional<User> user;
  std::optional<Backbone> backbone;
  std::optional<GroupKeysSource> group_keys;

  /// There are keys of the line, or something that may have them.
  bool secures_line() const { return keyring || user || backbone; }
  /// There is something to derive: the line waits for it.
  bool any() const { return secures_line() || group_keys; }
};

/// True if both give the same keys.
bool same_access(const SecureOptions& one, const SecureOptions& other);

/// `secure`, `keyring` and the keys without a keyring, with the files that they name. Errors
/// are added to those of the reader.
SecureOptions read_secure_options(const network::NetworkConfig& config, transport::Transports& transports,
                                  const LineOptions& line);

/// The keys of one line.
struct SecureAccess {
  std::optional<secure::SessionKeys> session{};
  std::optional<wire::IndividualAddress> tunnel{};  ///< the tunnel of the session's user
  std::vector<line::Gateway> gateways{};            ///< all tunnels of several hosts, in the order of preference
  std::optional<secure::RoutingKeys> routing{};
  std::string multicast{};  ///< of the keyring's backbone; empty = not known
  std::string plain{};      ///< why the line is plain although keys for it were given; for the user
  secure::GroupKeys groups{};
};

/// Decrypts the keyring and derives the keys of passwords: some 15 ms for each, so not on the event loop. Errors are
/// those of Keyring, with the name of the file: kIo of OpenSSL, kBusy if all tunnels are `taken`, else a matter of
/// configuration. `taken`: tunnels of the keyring that are in use.
Result<SecureAccess> derive_access(const SecureOptions& options, const LineOptions& line,
                                   std::span<const wire::IndividualAddress> taken = {});

/// Adds the secured groups that have no key, so that a guard neither sends to them nor accepts plain telegrams to them.
/// Returns these groups, in the order of `secured`.
std::vector<wire::GroupAddress> add_without_keys(secure::GroupKeys& keys,
                                                 const std::vector<wire::GroupAddress>& secured);

/// Names these groups and what to do, for the state of the line and for `check`; empty for no group.
std::string explain_missing_keys(const std::vector<wire::GroupAddress>& groups, const SecureOptions& options);

/// Adds what KNX Secure lacks, for `check`. Tries the passwords, which takes some 15 ms each. `secured`: the groups
/// that the import or the options secure.
void add_missing_keys(const SecureOptions& secure, const LineOptions& line,
                      const std::vector<wire::GroupAddress>& secured, bool remembers,
                      std::vector<network::Missing>& all);

}  // namespace rubicon::networks::knx
