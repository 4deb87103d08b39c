#pragma once

#include <memory>

#include "base/scheduler.h"
#include "transport/local_stream.h"

namespace rubicon::tuples::host {

/// A stream from this process to itself: what is written is received in a later turn.
std::unique_ptr<transport::LocalStream> make_loop_stream(Scheduler& scheduler, transport::LocalCalls calls);

}  // namespace rubicon::tuples::host
