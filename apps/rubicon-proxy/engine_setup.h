#pragma once

#include <optional>
#include <string>
#include <vector>

#include "island/island_config.h"
#include "tuples/engines/engines.h"

namespace rubicon::daemon {

/// Where the island meets the programs of its host: the folder and space of the environment come before those of the
/// file. kInvalid: the folder is not an absolute path.
Result<tuples::engines::HostSetup> host_setup(const config::EngineSetup& engine);

/// Whether some users of the host may not do everything: the island has rights, had
/// certificates for DDS, or other users share its folder. What listens on loopback must ask for a proof then, because
/// all users of the host reach it.
bool is_closed(const island::IslandConfig& config);

/// Who may command the island, for people: `whoever may enter /run/rubicon may command it`. Empty if rights decide
/// about members that the host or the broker names, and if no other process reaches the island.
std::string who_may_command(const island::IslandConfig& config);

/// Earlier releases had certificates for DDS. An island that had them, by its file, RUBICON_TRUST or the folder
/// /etc/rubicon/trust, must not be open to its network because of an upgrade: it does not take part by DDS until its
/// file says `trust: no`. What else it has runs.
void hold_back_dds(config::EngineSetup& engine);

/// Why, and what to choose: two lines. If nothing is held back: one line about a key that has no meaning any more, or
/// none.
std::vector<std::string> held_back_lines(const config::EngineSetup& engine);

}  // namespace rubicon::daemon
