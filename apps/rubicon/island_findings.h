#pragma once

#include <map>
#include <optional>
#include <string>

#include "apps/rubicon/findings.h"
#include "apps/rubicon/losses.h"

namespace rubicon::cli {

/// What `rubicon doctor` saw of an island, twice some seconds apart.
struct IslandSeen {
  client::Component island;
  bool answers = false;
  bool known_before = false;  ///< the first look saw all of it: what is higher at the second one grew meanwhile
  std::vector<client::Network> before, now;
  Counters numbers_before, numbers;               ///< its own
  std::map<std::string, std::string> properties;  ///< its own at the second look, texts too
  /// What its clock said less what ours said; nullopt: it does not tell (an older version).
  std::optional<Duration> clock_offset;
};

// Pure: what follows from what was seen. Each gives one finding or more of one name.

/// `line`: lines that are not up. `when`: of the second look.
Findings check_lines(const IslandSeen& seen, WallTime when);
/// `devices`: that cannot be reached.
Findings check_devices(const IslandSeen& seen);
/// `loss`: counters of the island and of its networks. A problem if they grew between the looks, else a note; a note
/// also where the first look does not say what they were.
Findings check_losses(const IslandSeen& seen);
/// `disk`: room for the state file and for recordings, recorders that drop records.
Findings check_disks(const IslandSeen& seen);
/// `clock`: of the island against ours, and ours. `when`: what ours said.
Findings check_clock(const IslandSeen& seen, WallTime when);
/// `inbox`: devices that wait for a decision.
Findings check_inbox(const IslandSeen& seen);
/// `access`: who can read and command the island.
Finding check_access(const IslandSeen& seen, const client::Options& options);

/// `6541 home`
std::string name_of(const client::Component& island);
/// Where a page of the documentation stands: `/usr/local/share/doc/rubicon/docs/errors.md#...` where it is installed
/// with this program, else `docs/errors.md#...`.
std::string page(std::string_view name);

}  // namespace rubicon::cli
