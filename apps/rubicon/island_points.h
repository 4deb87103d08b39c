#pragma once

#include <string>

#include "apps/rubicon/island_option.h"
#include "apps/rubicon/session.h"

namespace rubicon::cli {

// Points of the islands themselves, which take commands: settings, recorders, replays (docs/tuple-keys.md).

/// The only island that has a tuple under this key; otherwise the exit code after an error was printed. `what` names
/// the point in that error.
struct ChosenIsland {
  OwnerId id{};
  int code = kGood;
};
ChosenIsland choose_island(Session& session, const IslandOption& option, const std::string& key,
                           const std::string& what);

/// Sets a `.command` and prints the outcome: `done` on success, else state and reason on standard error. The exit code.
int command_island(Session& session, OwnerId island, const std::string& key, const std::string& text,
                   const std::string& done);

}  // namespace rubicon::cli
