#pragma once

#include <string>

#include "island/island_config.h"
#include "tuples/engines/engines.h"

namespace rubicon::daemon {

/// Where the island meets the programs of its host: the folder and space of the environment come before those of the
/// file. kInvalid: the folder is no absolute path.
Result<tuples::engines::HostSetup> host_setup(const config::EngineSetup& engine);

/// Whether some users of the host may not do everything: the island has rights, had
/// certificates for DDS, or other users share its folder. What listens on loopback must ask for a proof then, because
/// all users of the host reach it.
bool is_closed(const island::IslandConfig& config);

/// Who may command the island, for people: `whoever may enter /run/rubicon may command it`. Empty if rights decide
/// about those whom the host or the broker names, and if no other process reaches the island.
std::string who_may_command(const island::IslandConfig& config);

}  // namespace rubicon::daemon
