#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/rubicon-proxy/audit_part.h"
#include "base/log.h"
#include "bridges/bridge.h"
#include "config/bridge_config.h"
#include "island/island.h"
#include "rubicon/tuple_space.hpp"
#include "transport/transports.h"
#include "tuples/link.h"

namespace rubicon::daemon {

/// Errors of the options of bridges, which their types read.
void check_bridges(const std::vector<config::BridgeSetup>& setups, const std::string& directory,
                   base::ConfigErrors& errors);

/// The bridges of an island: components of their own beside it. Each set of one is judged and recorded as the member
/// `bridge:<name>`; without `rights:` the options of the bridge say what it may. The island does not depend on them:
/// one that cannot be opened says so, and is tried again by the next reload.
class BridgesPart {
 public:
  /// All must outlive it.
  struct Host {
    Scheduler& scheduler;
    tuples::Ecology& ecology;
    transport::Transports& transports;
    LogSink& log;
    island::Island& island;  ///< their statuses are tuples of it
    AuditPart& audit;
    std::shared_ptr<trust::rights::RightsJudge> judge;  ///< null: no member is judged
    /// The id of the component of a bridge; asked once for each place below kMaxBridges.
    std::function<OwnerId(std::size_t place)> new_id;
  };

  explicit BridgesPart(Host host);
  ~BridgesPart();

  /// What the configuration of the island names from now on: starts new bridges, ends removed ones, restarts changed
  /// ones, and after a change of the rights all.
  void take();

 private:
  struct One;
  trust::rights::RightsJudge& judge();
  void end_others(bool all);
  Result<void> open(One& one);
  void show();
  std::size_t free_place() const;
  OwnerId id_of(std::size_t place);

  Host host_;
  std::shared_ptr<trust::rights::RightsJudge> own_judge_;  ///< where there are no `rights:`
  std::optional<config::RightsSetup> rights_;              ///< that the bridges run with
  std::vector<OwnerId> ids_;                               ///< by place: a certificate has only some
  std::vector<std::unique_ptr<One>> all_;
  Timer show_;
};

}  // namespace rubicon::daemon
