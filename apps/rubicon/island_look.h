#pragma once

#include "apps/rubicon/island_findings.h"

namespace rubicon::cli {

/// Looks at all islands that are met, twice, so far apart; waits.
std::vector<IslandSeen> look_at_islands(Client& client, Duration between, Duration patience);

}  // namespace rubicon::cli
