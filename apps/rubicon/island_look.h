#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/rubicon/island_findings.h"

namespace rubicon::cli {

/// Two looks at all islands that are there. What comes between them is in the second one only.
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

/// Looks at all islands that are met, twice, so far apart; waits.
std::vector<IslandSeen> look_at_islands(Client& client, Duration between, Duration patience);

}  // namespace rubicon::cli
