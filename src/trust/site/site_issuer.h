#pragma once

#include <string>

#include "trust/site/brokers.h"
#include "trust/site/passwords.h"
#include "trust/site/site_ledger.h"

namespace rubicon::trust::site {

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
