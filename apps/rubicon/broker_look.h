#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "rubicon/client.hpp"
#include "transport/mqtt.h"

namespace rubicon::cli {

/// What a broker where components of sites meet shows to this user (docs/sites.md).
struct BrokerSeen {
  std::string place;             ///< `broker.lan:8883`
  std::string space, user;       ///< user `-`: nobody
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

}  // namespace rubicon::cli
