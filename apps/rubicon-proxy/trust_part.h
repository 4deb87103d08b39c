#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "config/engine_config.h"
#include "trust/site/live_realm.h"
#include "trust/trust.h"

namespace rubicon::daemon {

/// The folder of the certificates of an island, relative to that of its configuration: what `tuples.trust` says, else
/// RUBICON_TRUST (`no`, or a folder), else that of the host if there is one. Empty: without trust.
std::string trust_folder(const config::EngineSetup& engine, const std::string& directory);

/// `the certificate of island-1 ends in 12 days: ...`; empty while there is time.
std::string ending(const trust::Trust& trust);

/// The names and roles of all members that the folder knows: on the host with the authority those of the realm.
/// nullopt: there is no folder, or only some are known.
std::optional<std::vector<std::string>> names_of_members(const std::string& folder, WallTime now);

/// Who is who at that broker; nullptr: it is checked by no authority of a realm. The errors of LiveRealm::open().
Result<std::shared_ptr<trust::site::LiveRealm>> open_realm(const tuples::mqtt::SpaceOptions& space,
                                                           Scheduler& scheduler, LogSink& sink);

/// How the components of the daemon prove who they are.
class TrustPart {
 public:
  TrustPart(Scheduler& scheduler, LogSink& sink) : scheduler_(scheduler), sink_(sink), log_(sink, "trust") {}

  /// kIo: the error names the file, what is wrong and what was expected.
  Result<void> open(const std::string& folder, IslandId island);
  /// Null: the island has none.
  const std::shared_ptr<trust::Trust>& get() const { return trust_; }
  /// For a further component: an id of the island's block that no other one of this process has. Without trust, and if
  /// the certificate has no block: `otherwise`.
  OwnerId component_id(OwnerId otherwise);

 private:
  Scheduler& scheduler_;
  LogSink& sink_;
  Log log_;
  std::shared_ptr<trust::Trust> trust_;
  std::set<OwnerId> taken_;
};

}  // namespace rubicon::daemon
