#pragma once

#include <string>

#include "island/island_config.h"
#include "tuples/engines/engines.h"

namespace rubicon::daemon {

/// Where the island meets the programs of its host: the folder and space of the environment come before those of the
/// file. kInvalid: the folder is no absolute path.
Result<tuples::engines::HostSetup> host_setup(const config::EngineSetup& engine);

/// Whether users of the host, or others, may not do what they like: by trust, by rights, or because other users have
/// the folder too. What listens on loopback without asking is open to all users.
bool is_closed(const island::IslandConfig& config);

/// `whoever may enter /run/rubicon may command it`; empty where rights, or trust, say who may, and where nobody else
/// reaches the island.
std::string who_may_command(const island::IslandConfig& config);

}  // namespace rubicon::daemon
