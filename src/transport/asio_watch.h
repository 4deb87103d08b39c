#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "transport/descriptor_watch.h"

namespace rubicon::transport {

class Loop;

/// Watches descriptors in the io_context of the executor, which outlives the watches.
WatchDescriptor asio_watch(boost::asio::any_io_executor executor);
/// The loop must outlive what it makes.
WatchDescriptor asio_watch(Loop& loop);

}  // namespace rubicon::transport
