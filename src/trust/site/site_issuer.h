#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trust/site/brokers.h"
#include "trust/site/site_folder.h"
#include "trust/site/site_proofs.h"

namespace rubicon::trust::site {

/// A member that was made, with a certificate or a password. Names are never given twice.
struct SiteEntry {
  std::string user;
  std::string serial;  ///< of the certificate; empty = the user has a password
  WallTime ends{};     ///< of the certificate
  std::optional<WallTime> revoked;

  bool has_certificate() const { return !serial.empty(); }
  bool has_ended(WallTime now) const { return has_certificate() && ends < now; }
};

/// What the authority gave away and took back.
class SiteLedger {
 public:
  static Result<SiteLedger> read(const SiteFolder& folder);
  Result<void> write(const SiteFolder& folder) const;

  const std::vector<SiteEntry>& entries() const { return entries_; }
  /// Letters of either case are the same here: mail and file systems take them for the same.
  bool has_name(std::string_view user) const;
  void add(SiteEntry entry) { entries_.push_back(std::move(entry)); }
  /// All of the name that were not revoked before.
  void revoke(std::string_view user, WallTime when);
  /// Of certificates that have not ended.
  std::vector<RevokedSerial> revoked(WallTime now) const;
  /// Whether the certificates of this name have all ended, so that no list needs it.
  bool has_ended(std::string_view user, WallTime now) const;

 private:
  std::vector<SiteEntry> entries_;
};

/// The authority of a folder at work: has the folder for itself until it is destroyed. Changes are on the disk after
/// save().
class SiteIssuer {
 public:
  /// kDuplicate: the folder has a realm already.
  static Result<SiteIssuer> create(const std::filesystem::path& root, const std::string& realm, WallTime now);
  static Result<SiteIssuer> open(const std::filesystem::path& root, WallTime now);

  const SiteFolder& folder() const { return folder_; }
  const Certificate& authority() const { return authority_; }
  const PrivateKey& key() const { return key_; }
  WallTime now() const { return now_; }

  SiteRealm realm;
  SiteLedger ledger;
  PasswordLines passwords;  ///< of members with a password
  BrokerList brokers;

  /// A certificate for this user, which the ledger has already.
  Result<Certificate> certify(const std::string& user, EVP_PKEY* key, int days);
  /// Ledger first, then passwords, then the realm with its next number, then the revocation list.
  Result<void> save();
  /// The ledger alone: before a certificate leaves the process.
  Result<void> save_ledger() const { return ledger.write(folder_); }
  Result<void> save_brokers() const { return brokers.write(folder_); }
  /// The newest signed realm.
  const std::string& document() const { return document_; }
  /// The revocation list in PEM.
  Result<std::string> revocation() const;

 private:
  SiteIssuer(SiteFolder folder, base::OwnFile lock, Certificate authority, PrivateKey key, WallTime now)
      : folder_(std::move(folder)),
        lock_(std::move(lock)),
        authority_(std::move(authority)),
        key_(std::move(key)),
        now_(now) {}
  Result<void> read();

  SiteFolder folder_;
  base::OwnFile lock_;
  Certificate authority_;
  PrivateKey key_;
  std::string document_;
  WallTime now_;
};

}  // namespace rubicon::trust::site
