#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "base/log.h"
#include "transport/udp.h"
#include "web/access/access.h"
#include "web/exchange.h"
#include "web/files/page.h"
#include "web/server/limits.h"
#include "web/server/tls.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::web::server {

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
