#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <string>

#include "transport/local_stream.h"

namespace rubicon::transport {

/// Longest path of a socket, in bytes (unix(7): sun_path with its end).
inline constexpr std::size_t kMaxSocketPath = 107;

/// Connects to a Unix stream socket; at once, because the kernel does. kNotFound: there is none; kUnreachable: nobody
/// listens on it; kBusy: too many connections wait to be accepted, try again a little later; kRefused: no permission;
/// kInvalid: the path is too long; else kIo. The executor's io_context must outlive the stream.
Result<std::unique_ptr<LocalStream>> connect_asio_local(const boost::asio::any_io_executor& executor,
                                                        const std::string& path, LocalCalls calls);

/// Binds and listens at a path where nothing is, and gives its user and group access (0660), whatever the umask. The
/// socket remains in its folder. kDuplicate: there is something; kInvalid: the path is too long; kRefused: no
/// permission; else kIo. While the system has no descriptors left, connections wait.
Result<std::unique_ptr<LocalListener>> listen_asio_local(const boost::asio::any_io_executor& executor,
                                                         const std::string& path, LocalAccept accept);

}  // namespace rubicon::transport
