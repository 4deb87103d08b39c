#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "trust/folder_files.h"
#include "trust/site/site_realm.h"

namespace rubicon::trust::site {

// Where things lie in a folder of the realm of brokers (docs/sites.md).
inline constexpr const char* kAuthorityFile = "ca.pem";
inline constexpr const char* kRealmFile = "realm.p7s";
inline constexpr const char* kRevocationFile = "crl.pem";
inline constexpr const char* kAuthorityKeyFile = "ca/authority.key";
std::string member_certificate(const std::string& user);  ///< `members/hall/certificate.pem`
std::string member_key(const std::string& user);
std::string member_password(const std::string& user);

/// A user of this host by whom a service runs.
struct ServiceUser {
  uid_t user = 0;
  gid_t group = 0;
};
/// nullopt: this host has none of that name.
std::optional<ServiceUser> service_user(const std::string& name);

/// Reads and writes the parts of such a folder.
class SiteFolder {
 public:
  explicit SiteFolder(std::filesystem::path root) : files_(std::move(root)) {}
  const FolderFiles& files() const { return files_; }

  bool has_realm() const { return files_.exists(kAuthorityFile); }
  bool has_authority() const { return files_.exists(kAuthorityKeyFile); }
  /// kNotFound with what to do: there is no realm.
  Result<void> check_realm() const;
  /// Checked, valid now.
  Result<Certificate> authority(WallTime now) const;
  Result<std::string> realm_document() const;
  Result<SiteRealm> realm(const Certificate& authority) const;
  /// Those that have a certificate or a password here, in the order of their names.
  std::vector<std::string> members() const;
  bool has_key(const std::string& user) const { return files_.exists(member_key(user)); }
  /// A certificate of this folder, unchecked but for its form.
  Result<Certificate> certificate(const std::string& user) const;
  Result<PrivateKey> key(const std::string& user) const;

  /// Makes the folder, its `members`, and `ca` if asked for.
  Result<void> prepare(bool with_authority) const;
  Result<void> write_authority(const Certificate& authority) const;
  Result<void> write_realm(std::string_view document) const;
  Result<void> write_certificate(const std::string& user, const Certificate& certificate) const;
  /// Written by root for the service `rubicon`, if the host has its user: 0600, for the people of the host 0640. Else
  /// for the user of this process.
  Result<void> write_key(const std::string& user, const PrivateKey& key, KeyReaders readers) const;
  Result<void> write_password(const std::string& user, std::string_view password, KeyReaders readers) const;

 private:
  Result<void> write_secret(const std::string& user, const std::string& name, std::string_view text,
                            KeyReaders readers) const;

  FolderFiles files_;
};

/// A realm as people compare it.
struct RealmIdentity {
  std::string name;         ///< with its random end: `Rubicon 5f1c`
  std::string fingerprint;  ///< SHA-256 of the authority: 16 groups of 4 upper-case digits, separated by blanks
};
RealmIdentity identity_of(const Certificate& authority);

}  // namespace rubicon::trust::site
