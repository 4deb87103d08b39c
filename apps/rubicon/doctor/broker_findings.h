#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/rubicon/doctor/island_findings.h"
#include "rubicon/client.hpp"
#include "transport/mqtt.h"
#include "trust/site/live_realm.h"
#include "trust/site/site_operations.h"

namespace rubicon::cli {

/// What a broker where components of sites meet shows to this user (docs/sites.md).
struct BrokerSeen {
  std::string place;             ///< `broker.lan:8883`
  std::string space, user;       ///< user `-`: without one
  std::optional<Error> failure;  ///< why there is no connection
  transport::MqttVersion version = transport::MqttVersion::k5;
  bool tls = false, retains = true;
  bool hands_on = false;  ///< what this user sends to itself comes back: its rights are there, and all was read
  bool forges = false;    ///< what it writes in the name of another is taken
  std::map<std::string, std::set<OwnerId>> users;             ///< of presence, with their components
  std::vector<std::pair<std::string, OwnerId>> ghosts;        ///< components whose connection is not shown
  std::map<std::string, std::string, std::less<>> documents;  ///< realm files, by who shows them
};

/// Connects as the options say, beside what else this program has there, and reads what is retained; waits, at most
/// `patience` for each of both.
BrokerSeen look_at_broker(const client::Options& options, Duration patience);

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
