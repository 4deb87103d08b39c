#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "networks/knx/keyring/keyring_file.h"
#include "networks/knx/secure/crypto.h"
#include "networks/knx/secure/group_keys.h"
#include "networks/knx/secure/line_keys.h"

namespace rubicon::networks::knx::keyring {

/// Decrypts the values of one keyring.
class Cipher {
 public:
  /// From the password of the keyring, in UTF-8: PBKDF2, some 15 ms. Errors: those of OpenSSL.
  static Result<Cipher> make(const secure::Secret& password, std::string_view created);
  /// From the key that the password gives.
  static Result<Cipher> of_key(secure::Key key, std::string_view created);

  /// A group key, backbone key or tool key; kInvalid unless it is one block.
  Result<secure::Key> key(ByteView encrypted) const;
  /// A password: 8 random bytes, then UTF-8, then padding as of PKCS#7, of up to 32 bytes. kInvalid: that is not what
  /// comes out.
  Result<secure::Secret> password(ByteView encrypted) const;
  /// Bytes of valid padding at the end of what comes out; 0 = none.
  std::size_t padding(ByteView encrypted) const;
  /// Whether this key signed the file.
  Result<bool> signed_by_this(const KeyringFile& file) const;
  /// The signature of these bytes.
  Result<secure::Block> sign(ByteView signed_bytes) const;

 private:
  Cipher(secure::Key key, const secure::Block& start) : key_(std::move(key)), start_(start) {}

  secure::Key key_;
  secure::Block start_;
};

/// What a client needs to open one tunnel.
struct TunnelAccess {
  wire::IndividualAddress address{};  ///< of the tunnel
  wire::IndividualAddress host{};     ///< of the server; 0.0.0 = not in the keyring
  std::uint8_t user = 0;
  secure::Secret password;
  std::optional<secure::Secret> authentication{};  ///< of the server

  /// The keys of the passwords: PBKDF2 for each, so not on the event loop. Errors: those of OpenSSL.
  Result<secure::SessionKeys> session_keys() const;
};

struct RoutingAccess {
  std::string multicast;
  secure::RoutingKeys keys;
};

/// A decrypted keyring with a good signature. Tool keys and management passwords are not kept: nothing here uses them.
class Keyring {
 public:
  /// Checks the signature and decrypts. kRefused: the password is wrong; kInvalid: the file was changed after its
  /// export, as what the password decrypts shows; kRefused, naming both, where the file has no password that could show
  /// which it is. Each with a sentence for the user, without the name of the file. Blocks for some 15 ms.
  static Result<Keyring> open(const KeyringFile& file, const secure::Secret& password);
  static Result<Keyring> open(const KeyringFile& file, const Cipher& cipher);

  /// The wanted tunnel: named by its own address, or by the address of its server.
  struct Selection {
    std::optional<wire::IndividualAddress> tunnel{}, server{};
    std::span<const wire::IndividualAddress> taken{};  ///< tunnels that are in use
  };
  /// The wanted tunnel, else the free tunnel of the server that has the lowest user number; without a server, that of
  /// the only server of the keyring. kNotFound: no such tunnel, or it has no user or password; kBusy: all are taken;
  /// kInvalid: several servers. Each names what the keyring has.
  Result<TunnelAccess> tunnel(const Selection& selection) const;
  /// nullopt: the keyring has no backbone key.
  const std::optional<RoutingAccess>& routing() const { return routing_; }
  /// The senders come from the interface with the line's address. For groups that it is not linked with, they come from
  /// all interfaces. Telegrams may be sent from the addresses of the interfaces that are linked with the group, and
  /// from those that any interface lists as senders; from each address where no interface knows the group.
  secure::GroupKeys groups() const;
  /// The keyring has a tunnel with a user and a password.
  bool has_secure_tunnel() const;

 private:
  struct Interface {
    TunnelAccess access;
    bool is_tunnel = false, has_password = false;
    std::vector<KeyringFile::Group> groups;

    bool is_secure_tunnel() const { return is_tunnel && has_password && access.user != 0; }
  };

  Keyring() = default;
  Result<void> decrypt(const KeyringFile& file, const Cipher& cipher);
  Result<void> decrypt(const KeyringFile::Backbone& from, const Cipher& cipher);
  Result<void> decrypt(const KeyringFile::Interface& from, const Cipher& cipher);
  Result<void> decrypt(const KeyringFile::GroupKey& from, const Cipher& cipher);
  Result<void> decrypt(const KeyringFile::Device& from, const Cipher& cipher);
  void add_links(secure::GroupKeys& keys) const;
  Result<TunnelAccess> wanted_tunnel(wire::IndividualAddress address) const;
  Result<TunnelAccess> free_tunnel(const Selection& selection) const;
  TunnelAccess access_of(const Interface& interface) const;
  std::string tunnels_text() const;

  std::vector<Interface> interfaces_;
  std::optional<RoutingAccess> routing_;
  std::vector<std::pair<wire::GroupAddress, secure::Key>> group_keys_;
  std::map<wire::IndividualAddress, secure::Secret> device_codes_;
  std::map<wire::IndividualAddress, std::uint64_t> sequences_;
};

}  // namespace rubicon::networks::knx::keyring
