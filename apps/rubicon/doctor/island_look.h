#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/rubicon/doctor/island_findings.h"

namespace rubicon::cli {

/// Observes all present islands twice. An island that comes in between has the second observation only.
class IslandLook {
 public:
  IslandLook(Client& client, Duration patience);

  /// These wait.
  void first();
  std::vector<IslandSeen> second();

 private:
  using Properties = std::map<std::string, std::string>;

  void add_newcomers();
  IslandSeen seen_first(client::Component island);
  void look_again(IslandSeen& seen);
  Properties properties_of(OwnerId island);

  Client& client_;
  Duration patience_;
  std::map<OwnerId, Duration> clock_offsets_;  ///< by the last word of each
  Handle clocks_;
  std::vector<IslandSeen> all_;
};

/// Observes all islands twice, `between` apart; waits.
std::vector<IslandSeen> look_at_islands(Client& client, Duration between, Duration patience);

}  // namespace rubicon::cli
