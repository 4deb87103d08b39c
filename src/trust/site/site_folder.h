#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "trust/certificate.h"
#include "trust/folder_files.h"

namespace rubicon::trust::site {

/// Bytes of the largest realm file, with its signature. A thousand members with an island and a role each take 60 kB.
inline constexpr std::size_t kMaxRealm = 256UL * 1024;

/// What the members of the brokers of a realm know of each other: who is a member, with which roles, which user an
/// island is, and who was shut out. A plain value. Any holder of the newest one passes it on, because its signature
/// proves it.
struct SiteRealm {
  static constexpr std::size_t kMaxMembers = 4096;
  static constexpr std::size_t kMaxIslands = 4096;
  static constexpr std::size_t kMaxRevoked = 1024;

  using Roles = std::vector<std::string>;

  std::string name;                                   ///< as the authority spells it: `Rubicon 5f1c`
  std::uint64_t number = 0;                           ///< grows with each change
  std::map<std::string, Roles, std::less<>> members;  ///< check_user_name()
  /// The users that may use each id: the user of its island, and users that may stand in for it.
  std::set<std::pair<std::uint32_t, std::string>> islands;
  std::set<std::string, std::less<>> revoked;  ///< names, none of them in `members`

  bool is_member(std::string_view user) const { return members.find(user) != members.end(); }
  bool is_revoked(std::string_view user) const { return revoked.find(user) != revoked.end(); }
  /// None for who is not a member.
  const Roles& roles_of(std::string_view user) const;
  /// Empty: no user may be this island.
  std::vector<std::string> members_of(OwnerId island) const;
  friend bool operator==(const SiteRealm&, const SiteRealm&) = default;
};

/// JSON on one line, without signature. kBusy: more members, islands or revoked names than there may be.
Result<std::string> realm_text(const SiteRealm& realm);
/// The reverse. Members of the object that this release does not know are left out, so that a newer release can still
/// shut a member out. kInvalid: anything else than realm_text() writes. `where` names the source in errors.
Result<SiteRealm> parse_realm(std::string_view json, std::string_view where);

/// The realm file: realm_text() signed by the authority (S/MIME). kBusy also if it has more than kMaxRealm bytes.
Result<std::string> sign_realm(const SiteRealm& realm, const Certificate& authority, const PrivateKey& key);
/// The reverse: kInvalid if another key signed it, if it was changed, or is of another name than the authority.
Result<SiteRealm> read_realm(std::string_view document, const Certificate& authority, std::string_view where);

// Where things lie in a folder of the realm of brokers (docs/sites.md).
inline constexpr const char* kAuthorityFile = "ca.pem";
inline constexpr const char* kRealmFile = "realm.p7s";
inline constexpr const char* kRevocationFile = "crl.pem";
inline constexpr const char* kAuthorityKeyFile = "ca/authority.key";
std::string member_certificate(const std::string& user);  ///< `members/hall/certificate.pem`
std::string member_key(const std::string& user);
std::string member_password(const std::string& user);

/// The user of this host as which a service runs.
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
  /// The members with a certificate or a password here, in the order of their names.
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
