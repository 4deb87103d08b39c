#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <string>

#include "transport/serial.h"
#include "transport/stream.h"

namespace rubicon::transport {

/// A serial line of the machine whose calls run on this executor; its io_context must outlive it. As
/// Transports::open_serial.
Result<std::unique_ptr<ByteStream>> open_asio_serial(const boost::asio::any_io_executor& executor,
                                                     const SerialOptions& options, StreamCalls calls);

/// As Transports::make_pty.
Result<std::unique_ptr<ByteStream>> make_asio_pty(const boost::asio::any_io_executor& executor, const std::string& link,
                                                  StreamCalls calls);

}  // namespace rubicon::transport
