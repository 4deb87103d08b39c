#pragma once

#include <memory>

#include "transport/udp.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::transport {

/// What becomes of a datagram that the system answered with this error (errno; 0 = none).
enum class AfterSend : std::uint8_t {
  kSent,
  kWait,  ///< the socket is full: until it can be written to again
  kDrop,  ///< a queue behind it is full (ENOBUFS): the socket seems writable all the time, and waiting would never rest
  kRefused
};
AfterSend after_send(int error);

/// A socket of the machine on an io_context, which must outlive it. As Transports::open_udp.
Result<std::unique_ptr<UdpSocket>> open_asio_udp(boost::asio::io_context& context, const UdpOptions& options,
                                                 UdpCalls calls);

}  // namespace rubicon::transport
