#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rubicon/result.hpp"
#include "transport/asio_scheduler.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/engines/engines.h"

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

/// Runs the loop until it is known whether another process has the id by DDS or in a PEIS network; `listener` is a
/// space of this process that takes part there. A component that is still there a `lease` later is alive. kDuplicate
/// names it; kIo: `given_up` became true, or the loop was stopped.
Result<void> await_alone(transport::Loop& loop, const tuples::engines::Engines& engines, const TupleSpace& listener,
                         OwnerId id, Duration lease, const std::function<bool()>& given_up);

}  // namespace rubicon::daemon
