#pragma once

#include <functional>

#include "rubicon/result.hpp"
#include "transport/asio_scheduler.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::daemon {

/// Runs the loop until it is known whether another process has the id by DDS: a component of this process has to listen
/// there. A presence that is still there a `lease` later belongs to a process that lives. kDuplicate names it; kIo:
/// `given_up` became true, or the loop was stopped.
Result<void> await_alone(transport::Loop& loop, const tuples::dds::DdsEcology& dds, OwnerId id, Duration lease,
                         const std::function<bool()>& given_up);

}  // namespace rubicon::daemon
