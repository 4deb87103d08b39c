#pragma once

#include <functional>

#include "rubicon/result.hpp"
#include "transport/asio_scheduler.h"
#include "tuples/engines/engines.h"

namespace rubicon::daemon {

/// Runs the loop until it is known whether another process has the id by DDS or in a PEIS network; `listener` is a
/// space of this process that takes part there. Who is still there a `lease` later lives. kDuplicate names it; kIo:
/// `given_up` became true, or the loop was stopped.
Result<void> await_alone(transport::Loop& loop, const tuples::engines::Engines& engines, const TupleSpace& listener,
                         OwnerId id, Duration lease, const std::function<bool()>& given_up);

}  // namespace rubicon::daemon
