#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/log.h"
#include "base/scheduler.h"
#include "trust/site/site_folder.h"
#include "trust/site/site_identity.h"
#include "tuples/judge.h"

namespace rubicon::trust::site {

/// The newest realm that a process knows: from its folder, from its state folder, or from other members. A realm with a
/// lower number never replaces it, also not after a restart. The text is public, and every member passes a newer one
/// on: only the signature of the authority counts.
class KnownRealm {
 public:
  /// Reads and checks the files; a damaged copy in the state folder counts as none.
  static Result<KnownRealm> open(const SitePlace& place, WallTime now);

  const SiteRealm& realm() const { return realm_; }
  /// The text as it is passed on, at most kMaxRealm bytes.
  const std::string& document() const { return document_; }
  const Certificate& authority() const { return authority_; }

  /// Takes a text that another member passed on. True: it is newer, and known from now on, also on the disk, if this
  /// process may write either folder. Errors: it is not a realm of our authority; `from` names who it came from.
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

/// The realm of a process for as long as it runs: who the users of its broker are. Looks for a newer file in its
/// folder, and takes what other members show.
class LiveRealm final : public tuples::UserRealm {
 public:
  /// What is found on the disk counts within this time.
  static constexpr Duration kLook = std::chrono::seconds(4);
  /// Every member may use ids from here on; ids below belong to islands.
  static constexpr std::uint32_t kFirstFreeId = 65536;

  /// The realm whose authority is in that file, for the user that this process is; null: the folder has no realm file.
  /// The errors of KnownRealm::open(). The scheduler outlives it.
  static Result<std::shared_ptr<LiveRealm>> open(const std::string& ca_file, const std::string& user,
                                                 base::Scheduler& scheduler, Log log);

  const SiteRealm& realm() const { return known_.realm(); }

  std::shared_ptr<const tuples::Member> member(std::string_view user) const override;
  const std::string& document() const override { return known_.document(); }
  Taken take(std::string_view document, std::string_view from) override;
  [[nodiscard]] tuples::Handle watch(std::function<void()> call) override;

 private:
  LiveRealm(KnownRealm known, std::string user, base::Scheduler& scheduler, Log log);
  void look();
  void changed();
  void read_members();

  KnownRealm known_;
  std::string user_;
  base::Scheduler& scheduler_;
  Log log_;
  std::map<std::string, std::shared_ptr<const tuples::Member>, std::less<>> members_;
  using Watches = std::map<std::uint64_t, std::function<void()>>;
  std::shared_ptr<Watches> watches_ = std::make_shared<Watches>();  ///< shared with the handles, which may outlive this
  std::uint64_t last_watch_ = 0;
  Timer look_;
};

}  // namespace rubicon::trust::site
