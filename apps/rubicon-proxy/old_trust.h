#pragma once

#include <optional>
#include <string>
#include <vector>

#include "island/island_config.h"

namespace rubicon::daemon {

/// Earlier releases had certificates for DDS. An island that had them, by its file, RUBICON_TRUST or the folder
/// /etc/rubicon/trust, must not be open to its network because of an upgrade: it does not take part by DDS until its
/// file says `trust: no`. What else it has runs.
void hold_back_dds(config::EngineSetup& engine);

/// Why, and what to choose: two lines. Where nothing is held back one about a key that means nothing any more, or none.
std::vector<std::string> held_back_lines(const config::EngineSetup& engine);

}  // namespace rubicon::daemon
