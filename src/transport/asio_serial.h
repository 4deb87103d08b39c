#pragma once

#include <memory>
#include <string>

#include "transport/serial.h"
#include "transport/stream.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::transport {

/// A serial line of the machine on an io_context, which must outlive it. As Transports::open_serial.
Result<std::unique_ptr<ByteStream>> open_asio_serial(boost::asio::io_context& context, const SerialOptions& options,
                                                     StreamCalls calls);

/// As Transports::make_pty.
Result<std::unique_ptr<ByteStream>> make_asio_pty(boost::asio::io_context& context, const std::string& link,
                                                  StreamCalls calls);

}  // namespace rubicon::transport
