#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trust/site/site_certificates.h"
#include "trust/site/site_folder.h"

namespace rubicon::trust::site {

/// Who was made a member, by certificate or password. Names are never given twice.
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

}  // namespace rubicon::trust::site
