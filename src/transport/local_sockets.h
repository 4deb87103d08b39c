#pragma once

#include <memory>
#include <string>

#include "base/scheduler.h"
#include "transport/descriptor_watch.h"
#include "transport/local_stream.h"

namespace rubicon::transport {

/// As Transports::open_local(). The loop behind `watch` outlives the stream.
Result<std::unique_ptr<LocalStream>> open_local_socket(const WatchDescriptor& watch, const std::string& path,
                                                       LocalCalls calls);
/// As Transports::listen_local(). The loop behind `watch` and the scheduler outlive the listener and its streams.
Result<std::unique_ptr<LocalListener>> listen_local_socket(const WatchDescriptor& watch, Scheduler& scheduler,
                                                           const std::string& path, LocalAccept accept);

}  // namespace rubicon::transport
