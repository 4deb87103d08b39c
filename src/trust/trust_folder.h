#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rubicon/result.hpp"
#include "trust/folder_files.h"
#include "trust/realm.h"

namespace rubicon::trust {

/// Where things lie in a trust folder (docs/trust.md).
inline constexpr const char* kIdentityCaFile = "identity-ca.pem";
inline constexpr const char* kPermissionsCaFile = "permissions-ca.pem";
inline constexpr const char* kGovernanceFile = "governance.p7s";
inline constexpr const char* kRevokedFile = "revoked.p7s";
inline constexpr const char* kIdentityKeyFile = "ca/identity.key";
inline constexpr const char* kPermissionsKeyFile = "ca/permissions.key";
std::string certificate_file(const std::string& member);  ///< `members/desk/certificate.pem`
std::string permissions_file(const std::string& member);
std::string key_file(const std::string& member);

/// Reads and writes the parts of a trust folder.
class TrustFolder {
 public:
  explicit TrustFolder(std::filesystem::path root) : files_(std::move(root)) {}
  const FolderFiles& files() const { return files_; }

  bool has_realm() const { return files_.exists(kIdentityCaFile); }
  bool has_authority() const { return files_.exists(kIdentityKeyFile); }
  /// kNotFound: the folder has none. Other errors: this user cannot see whether it has.
  Result<void> check_authority() const;
  /// The papers of all members.
  Result<Papers> realm_papers() const;
  /// With those of one member.
  Result<Papers> papers(const std::string& member) const;
  /// Both keys, checked against the certificates. kNotFound: the folder `ca` is somewhere else.
  Result<Authority> authority(WallTime now) const;
  /// The members that have a certificate here, in the order of their names.
  std::vector<std::string> members() const;
  /// A certificate of this folder as it is read, unchecked but for its form.
  Result<Certificate> certificate(const std::string& name) const;
  Result<tuples::Member> member(const std::string& name) const;

  /// Makes the folder, its `members`, and `ca` if asked for.
  Result<void> prepare(bool with_authority) const;
  Result<void> write_authority(const Authority& authority) const;
  /// The certificate of the identities comes last: with it the folder has a realm.
  Result<void> write_realm(const Papers& papers) const;
  Result<void> write_revoked(std::string_view document) const;
  /// That of kLocalMember is for the people always. Only root gives a key to them.
  Result<void> write_key(const std::string& member, const PrivateKey& key, KeyReaders readers) const;
  Result<void> write_member(const std::string& member, const Papers& papers) const;

 private:
  Result<Paper> read(const std::string& name, std::size_t largest) const;

  FolderFiles files_;
};

}  // namespace rubicon::trust
