#pragma once

#include <memory>

#include "transport/tcp.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::transport {

/// A connection of the machine on an io_context, which must outlive it. As Transports::open_tcp.
Result<std::unique_ptr<TcpStream>> open_asio_tcp(boost::asio::io_context& context, const TcpOptions& options,
                                                 TcpCalls calls);

/// A port of the machine on an io_context, which must outlive it. As Transports::listen_tcp.
Result<std::unique_ptr<TcpListener>> listen_asio_tcp(boost::asio::io_context& context, const Endpoint& local,
                                                     TcpAccept accept, ListenerFailed failed);

}  // namespace rubicon::transport
