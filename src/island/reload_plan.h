#pragma once

#include <string>
#include <vector>

#include "island/island_config.h"

namespace rubicon::island {

/// What taking another configuration would do to a running island.
struct ReloadPlan {
  std::vector<std::string> refusals;                 ///< what needs a restart; anything here = nothing is done
  std::vector<std::string> removed, added, changed;  ///< network ids; changed = their plug-ins get new options
  std::vector<std::string> retyped;                  ///< networks whose type changed: removed and added
  std::vector<std::string> lines;                    ///< everything, for people; empty = nothing changes
  std::vector<std::string> warnings;                 ///< names in `devices:` that fit nothing
};

ReloadPlan plan_reload(const IslandConfig& now, const IslandConfig& next);

}  // namespace rubicon::island
