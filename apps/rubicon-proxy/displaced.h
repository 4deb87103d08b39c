#pragma once

#include <string>
#include <vector>

#include "tuples/dds/component_starts.h"

namespace rubicon::daemon {

/// Name of the component that each daemon has beside its island. Its summary names the process.
inline constexpr const char* kConsole = "console of the island";

/// What to do about an island whose id another process has: `: stop that one, or ...`; empty for other components.
std::string way_out(OwnerId id);
/// Which process has the id of a component of ours, without a way out.
std::string in_use_text(OwnerId id, const std::vector<tuples::dds::ComponentStart>& starts);
/// What the log says when another process has the id of a component of ours: which one, and how to go on. `starts`: the
/// starts that were observed.
std::string displaced_text(OwnerId id, const std::vector<tuples::dds::ComponentStart>& starts);

}  // namespace rubicon::daemon
