#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "base/log.h"
#include "base/scheduler.h"
#include "trust/site/known_realm.h"
#include "tuples/user_realm.h"

namespace rubicon::trust::site {

/// The realm of a process for as long as it runs: who the users of its broker are. Looks for a newer file in its
/// folder, and takes what other members show.
class LiveRealm final : public tuples::UserRealm {
 public:
  /// What is found on the disk counts within this time.
  static constexpr Duration kLook = std::chrono::seconds(4);
  /// Ids from here on are free to every member; one below is that of an island.
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
