#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "trust/site/site_folder.h"
#include "trust/site/site_place.h"

namespace rubicon::trust::site {

/// The newest realm that a process knows: from its folder, from its state folder, or from other members. A realm with a
/// lower number never replaces it, also not after a restart. The text is public, and whoever has a newer one hands it
/// on: only the signature of the authority counts.
class KnownRealm {
 public:
  /// Reads and checks the files; a damaged copy in the state folder counts as none.
  static Result<KnownRealm> open(const SitePlace& place, WallTime now);

  const SiteRealm& realm() const { return realm_; }
  /// As it is handed on, at most kMaxRealm bytes.
  const std::string& document() const { return document_; }
  const Certificate& authority() const { return authority_; }

  /// What another member handed on. True: it is newer, and known from now on, also on the disk, if this process may
  /// write either folder. Errors: it is no realm of our authority; `from` names who it came from.
  Result<bool> take(std::string_view document, std::string_view from);
  /// Whether the folder has a newer one now, after `rubicon trust revoke` on this host, for example. A folder that
  /// cannot be read, or is damaged, changes nothing. Opens the file only if it was written since the last look.
  bool look();

 private:
  KnownRealm(SitePlace place, Certificate authority, SiteRealm realm, std::string document)
      : place_(std::move(place)),
        authority_(std::move(authority)),
        realm_(std::move(realm)),
        document_(std::move(document)) {}
  bool is_newer(const SiteRealm& other) const { return other.number > realm_.number; }
  void keep() const;
  bool keep_in(const FolderFiles& folder) const;

  SitePlace place_;
  Certificate authority_;
  SiteRealm realm_;
  std::string document_;
  /// Of the file in the folder, when it was read last.
  struct Version {
    std::int64_t seconds = 0, nanoseconds = 0, bytes = 0;
    std::uint64_t file = 0;
    bool operator==(const Version&) const = default;
  };
  Version version() const;
  Version looked_{};
};

}  // namespace rubicon::trust::site
