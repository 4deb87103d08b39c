#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "transport/tcp.h"

namespace rubicon::transport {

/// A connection of the machine whose calls run on this executor; its io_context must outlive it. As
/// Transports::open_tcp.
Result<std::unique_ptr<TcpStream>> open_asio_tcp(const boost::asio::any_io_executor& executor,
                                                 const TcpOptions& options, TcpCalls calls);

/// A port of the machine whose calls run on this executor; its io_context must outlive it. As Transports::listen_tcp.
Result<std::unique_ptr<TcpListener>> listen_asio_tcp(const boost::asio::any_io_executor& executor,
                                                     const Endpoint& local, TcpAccept accept, ListenerFailed failed);

}  // namespace rubicon::transport
