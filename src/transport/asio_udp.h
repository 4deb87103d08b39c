#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "transport/udp.h"

namespace rubicon::transport {

/// What to do with a datagram after send() failed with this error (errno; 0 = none).
enum class AfterSend : std::uint8_t {
  kSent,
  kWait,  ///< the socket's buffer is full: wait until it is writable
  kDrop,  ///< a queue of the system is full (ENOBUFS): the socket counts as writable, so waiting would be a busy loop
  kRefused
};
AfterSend after_send(int error);

/// A socket of the machine whose calls run on this executor; its io_context must outlive it. As Transports::open_udp.
Result<std::unique_ptr<UdpSocket>> open_asio_udp(const boost::asio::any_io_executor& executor,
                                                 const UdpOptions& options, UdpCalls calls);

}  // namespace rubicon::transport
