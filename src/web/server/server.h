#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/log.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "transport/sockets.h"
#include "web/access/access.h"
#include "web/exchange.h"
#include "web/files/page.h"

namespace boost::asio {
class io_context;
}

namespace boost::asio::ssl {
class context;
}

namespace rubicon::web::server {

/// What one client may cost, and for how long.
struct Limits {
  std::size_t connections = 64;
  std::size_t refused = 8;                        ///< further connections that are refused with an answer
  std::size_t target = std::size_t{8} << 10;      ///< bytes of the request target
  std::size_t head = std::size_t{16} << 10;       ///< bytes of request line and fields
  std::size_t body = std::size_t{1} << 20;        ///< bytes
  std::size_t upload = std::size_t{32} << 20;     ///< bytes of a body that is a file
  std::size_t message = std::size_t{64} << 10;    ///< bytes of an incoming WebSocket message
  std::size_t ahead = 64;                         ///< messages that are read while the client takes none of ours
  Duration handshake = std::chrono::seconds(10);  ///< of TLS
  Duration head_time = std::chrono::seconds(10);  ///< from the first byte of a request to the end of its head
  Duration body_time = std::chrono::seconds(30);
  Duration upload_time = std::chrono::minutes(5);
  Duration answer = std::chrono::minutes(10);   ///< for the site to answer
  Duration idle = std::chrono::seconds(60);     ///< between requests
  Duration stalled = std::chrono::seconds(30);  ///< a client that takes nothing for this long is closed
  Duration linger = std::chrono::seconds(2);    ///< for the client to read a refusal before its connection is closed
  Duration ping = std::chrono::seconds(20);     ///< between WebSocket pings
};

/// PEM files: the certificate with those that lead to its authority, and its key.
struct TlsFiles {
  std::string certificate, key;

  friend bool operator==(const TlsFiles&, const TlsFiles&) = default;
};

struct TlsSetup {
  std::shared_ptr<boost::asio::ssl::context> context;  ///< TLS 1.2 or later
  WallTime expires;                                    ///< of the certificate
};

/// Reads the files. kNotFound, kIo or kInvalid with the path.
Result<TlsSetup> read_tls(const TlsFiles& files);

struct ServerOptions {
  transport::Endpoint listen;     ///< numeric address; port 0 = any free one
  std::optional<TlsFiles> tls{};  ///< nullopt = plain
  bool compress = false;
  Limits limits{};
};

/// What the server did so far.
struct ServerCounters {
  std::uint64_t accepted = 0;
  std::uint64_t turned_away = 0;  ///< no room
  std::uint64_t requests = 0;
  std::uint64_t refused = 0;  ///< by Host, Origin or token
};

/// HTTP, WebSockets and event streams on one port, until it is destroyed. All that it is made with must outlive it.
class Server {
 public:
  struct Parts {
    boost::asio::io_context& context;
    Scheduler& scheduler;
    access::Access& access;
    Site& site;
    const files::Page& page;
    Log log;
  };

  /// kBusy: the port is in use. Errors of the certificate as read_tls().
  static Result<std::unique_ptr<Server>> open(const Parts& parts, ServerOptions options);
  ~Server();

  /// The bound address and port.
  transport::Endpoint local() const;
  bool secure() const;
  /// Reads the certificate again, for connections accepted from now on; on an error the one before stays.
  Result<void> reload();
  /// Closes all connections; what they are allowed to do has changed.
  void disconnect();
  std::size_t connections() const;
  const ServerCounters& counters() const;

 private:
  class Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::web::server
