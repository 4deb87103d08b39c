#pragma once

#include <map>
#include <optional>
#include <string>

#include "apps/rubicon/doctor/findings.h"
#include "apps/rubicon/doctor/signs.h"
#include "model/alerts.h"

namespace rubicon::cli {

/// Two observations of an island, some seconds apart.
struct IslandSeen {
  client::Component island;
  bool answers = false;
  bool known_before = false;  ///< the first observation is complete: counters can be compared
  std::vector<client::Network> before, now;
  Counters numbers_before, numbers;               ///< its own
  std::map<std::string, std::string> properties;  ///< its own at the second observation, also texts
  model::AlertList alerts;
  std::string history;                         ///< status of its history; empty = it has none
  std::map<std::string, std::string> bridges;  ///< their statuses by name
  /// Its clock minus ours; nullopt: an older version that does not publish its clock.
  std::optional<Duration> clock_offset;
};

// Pure functions of what was observed. Each returns findings of one check.

/// `line`: lines that are not up. `when`: time of the second observation.
Findings check_lines(const IslandSeen& seen, WallTime when);
/// `devices`: devices that are not reachable.
Findings check_devices(const IslandSeen& seen);
/// `loss`: counters of the island and of its networks. A problem if they grew between the observations, else a note; a
/// note also where the first observation is incomplete.
Findings check_losses(const IslandSeen& seen);
/// What networks dropped, refused or cannot use, by their property `problems`: the latest of each.
Findings check_problems(const IslandSeen& seen, WallTime when);
/// `disk`: room for the state file and for recordings, recorders that drop records.
Findings check_disks(const IslandSeen& seen);
/// `history`: whether its history is written.
Findings check_history(const IslandSeen& seen);
/// `bridges`: whether its bridges reach the other side, and what the other side refuses.
Findings check_bridges(const IslandSeen& seen);
/// `clock`: whether our clock was set, and whether the island's clock agrees with it. `when`: the time on our clock.
Findings check_clock(const IslandSeen& seen, WallTime when);
/// `alerts`: alerts of the island that no other check here covers: low batteries, commands that failed.
Findings check_alerts(const IslandSeen& seen);
/// `inbox`: devices that wait for a decision.
Findings check_inbox(const IslandSeen& seen);
/// `unusable`: devices that the network lists but cannot use (ZigBee: because of their names).
Findings check_unusable(const IslandSeen& seen);
/// `settings`: settings that the server of a network (Zigbee2MQTT) should change, as the network found them.
Findings check_settings(const IslandSeen& seen);
/// `broker`: networks whose MQTT broker is used without TLS or without a user.
Findings check_brokers(const IslandSeen& seen);
/// `dds`: an island that had certificates for DDS, and has to choose.
Findings check_held_back(const IslandSeen& seen);
/// `rights`: requests that the island refused because of its rights.
Findings check_rights(const IslandSeen& seen);
/// `interface`: those that the island uses for DDS and that reach no other host, and whether its addresses changed.
Findings check_interfaces_of(const IslandSeen& seen);
/// `access`: who can read and command the island.
Finding check_access(const IslandSeen& seen, const client::Options& options);
/// The same where components meet on this host alone, in this folder.
Finding check_access_of_host(const IslandSeen& seen, const std::string& folder);

/// `6541 home`
std::string name_of(const client::Component& island);
/// Where a page of the documentation stands: `/usr/local/share/doc/rubicon/docs/errors.md#...` where it is installed
/// with this program, else `docs/errors.md#...`.
std::string page(std::string_view name);

}  // namespace rubicon::cli
