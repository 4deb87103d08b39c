#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>

namespace rubicon::trust::site {

// Names of the files in a folder of a broker.
inline constexpr const char* kMosquittoFile = "mosquitto.conf";
inline constexpr const char* kAclFile = "acl";
inline constexpr const char* kBrokerAuthorityFile = "ca.pem";
inline constexpr const char* kBrokerRevocationFile = "crl.pem";
inline constexpr const char* kBrokerCertificateFile = "broker.pem";
inline constexpr const char* kBrokerKeyFile = "broker.key";
inline constexpr const char* kBrokerPasswordsFile = "passwords";
inline constexpr const char* kBrokerMoreFolder = "conf.d";  ///< of the administrator: never written again

/// A mosquitto 2.0 of a realm.
struct MosquittoSetup {
  std::string folder;  ///< with the files above, absolute
  std::string state;   ///< folder of its database, absolute
  std::string user;    ///< by whom it runs when root starts it; empty = what mosquitto chooses
  std::uint16_t port = 8883;
  bool takes_passwords = false;  ///< at the port after `port`

  friend bool operator==(const MosquittoSetup&, const MosquittoSetup&) = default;
};

/// The configuration (mosquitto.conf(5)): TLS with our authority; the name in the certificate is the user.
std::string mosquitto_conf(const MosquittoSetup& setup);
/// The access list: each user writes its own presence and to inboxes in its own name, and reads its own inbox and the
/// presence of all. Who was shut out has nothing, also on a connection that is up.
std::string mosquitto_acl(const std::set<std::string, std::less<>>& revoked);

}  // namespace rubicon::trust::site
