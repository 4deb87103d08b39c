#pragma once

#include <memory>
#include <optional>

#include "apps/rubicon/broker_look.h"
#include "apps/rubicon/island_findings.h"
#include "trust/site/live_realm.h"
#include "trust/site/site_operations.h"

namespace rubicon::cli {

// The broker where components of sites meet (docs/sites.md). Pure functions of what was observed, all of check `sites`.

/// What this program knows of the realm.
struct RealmSeen {
  rubicon::trust::site::SiteRealm realm;  ///< the newest one, of those that others show too
  std::uint64_t on_disk = 0;              ///< number of that in the folder
  std::string shown_by;                   ///< who shows the newest one, if that in the folder is older
  std::string folder;
  std::optional<WallTime> own_ends;  ///< of the certificate of this user
  std::optional<int> authority_days_left;
  std::vector<std::string> open_keys;  ///< paths of keys and passwords that others of this host may read
};

/// `realm`: nullptr = there is none.
Findings check_broker(const BrokerSeen& broker, const RealmSeen* realm, WallTime now);

/// What an island counted at its broker: a note if losses grew between the observations.
Findings check_broker_losses(const IslandSeen& seen);

/// Observes what check_broker() needs. The error says why the realm cannot be read; nullopt: there is none.
Result<std::optional<RealmSeen>> look_at_realm(const client::Options& options, const BrokerSeen& broker);

}  // namespace rubicon::cli
