#pragma once

#include <memory>

#include "transport/udp.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::transport {

/// A socket of the machine on an io_context, which must outlive it. As Transports::open_udp.
Result<std::unique_ptr<UdpSocket>> open_asio_udp(boost::asio::io_context& context, const UdpOptions& options,
                                                 UdpCalls calls);

}  // namespace rubicon::transport
