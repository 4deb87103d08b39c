#pragma once

#include <string>
#include <vector>

#include "tuples/dds/component_starts.h"

namespace rubicon::daemon {

/// Name of the component that each daemon has beside its island. Its summary names the process.
inline constexpr const char* kConsole = "console of the island";

/// What the log says when another process has the id of a component of ours: which one, and how to go on. `starts`: the
/// starts that were observed.
std::string displaced_text(OwnerId id, const std::vector<tuples::dds::ComponentStart>& starts);

}  // namespace rubicon::daemon
