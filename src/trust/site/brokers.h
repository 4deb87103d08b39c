#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "trust/site/site_folder.h"

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
  std::string user;    ///< user that it becomes when root starts it; empty = mosquitto's choice
  std::uint16_t port = 8883;
  bool takes_passwords = false;  ///< at the port after `port`

  friend bool operator==(const MosquittoSetup&, const MosquittoSetup&) = default;
};

/// The configuration (mosquitto.conf(5)): TLS with our authority; the name in the certificate is the user.
std::string mosquitto_conf(const MosquittoSetup& setup);
/// The access list: each user writes its own presence and to inboxes in its own name, and reads its own inbox and the
/// presence of all. A member that was shut out has no rights, also on a connection that is up.
std::string mosquitto_acl(const std::set<std::string, std::less<>>& revoked);

/// A folder with the files of a mosquitto, which this realm writes.
struct BrokerFolder {
  MosquittoSetup setup;
  std::string unit;  ///< `rubicon-broker@main`; empty = no unit runs it

  friend bool operator==(const BrokerFolder&, const BrokerFolder&) = default;
};

/// The brokers of a realm, as its authority knows them (`ca/brokers`).
struct BrokerList {
  std::vector<std::string> hosts;  ///< HOST or HOST:PORT, as members reach them; the first one is preferred
  std::vector<BrokerFolder> folders;

  static Result<BrokerList> read(const SiteFolder& folder);
  Result<void> write(const SiteFolder& folder) const;

  BrokerFolder* find(const std::string& folder);
  bool take_passwords() const;
  /// HOST:PORT of each host: where a member with a certificate, or one with a password, connects to.
  std::vector<std::string> addresses(bool with_password) const;
  /// The hosts without ports, for certificates.
  std::vector<std::string> names() const;
};

/// kInvalid: is no HOST or HOST:PORT.
Result<void> check_broker(const std::string& text);

}  // namespace rubicon::trust::site
