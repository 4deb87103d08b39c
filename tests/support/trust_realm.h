#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "trust/operations.h"
#include "trust/trust.h"

namespace rubicon::support {

/// A realm in one folder that has the keys of all its members: each process of a test takes its place. Valid by the
/// clock of the system and by that of a VirtualScheduler. Throws std::runtime_error where something fails.
class TrustRealm {
 public:
  /// Makes the realm with the members `local` (role admin) and `island-<id>`.
  TrustRealm(std::filesystem::path folder, const std::vector<OwnerId>& islands);

  const std::filesystem::path& folder() const { return folder_; }
  /// A further member.
  tuples::Member add(const std::string& name, const std::vector<std::string>& roles = {}, OwnerId island = {});
  /// Its certificates count no more; the signed list.
  std::string revoke(const std::string& name);
  void renew(const std::string& name);

  trust::Place place(const std::string& member) const { return {folder_, member, {}, {}}; }
  std::shared_ptr<trust::Trust> open(const std::string& member, base::Scheduler& scheduler, base::LogSink& sink) const;

 private:
  std::filesystem::path folder_;
};

/// The time of the system.
WallTime wall_clock();

}  // namespace rubicon::support
