#pragma once

#include <memory>

#include "transport/udp.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::transport {

/// What to do with a datagram after send() failed with this error (errno; 0 = none).
enum class AfterSend : std::uint8_t {
  kSent,
  kWait,  ///< the socket's buffer is full: wait until it is writable
  kDrop,  ///< a queue of the system is full (ENOBUFS): the socket counts as writable, so waiting would be a busy loop
  kRefused
};
AfterSend after_send(int error);

/// A socket of the machine on an io_context, which must outlive it. As Transports::open_udp.
Result<std::unique_ptr<UdpSocket>> open_asio_udp(boost::asio::io_context& context, const UdpOptions& options,
                                                 UdpCalls calls);

}  // namespace rubicon::transport
