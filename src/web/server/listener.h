#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "transport/sockets.h"

namespace boost::asio {
class io_context;
}

namespace boost::asio::ssl {
class context;
}

namespace rubicon::web::server {

class PeerStream;

/// Accepts connections on a port until it is destroyed.
class Listener {
 public:
  struct Callbacks {
    std::function<void(std::unique_ptr<PeerStream>)> accepted;
    std::function<void(Error)> failed;  ///< no connections are accepted any longer
  };
  using Context = std::shared_ptr<boost::asio::ssl::context>;

  virtual ~Listener() = default;
  /// The bound address and port.
  virtual transport::Endpoint local() const = 0;
  /// TLS of the connections accepted from now on; nullptr = plain.
  virtual void set_tls(Context context) = 0;

  /// Port 0 = any free one. kBusy: in use; kInvalid: no address of this machine; kIo: other errors of the system.
  static Result<std::unique_ptr<Listener>> open(boost::asio::io_context& context, Scheduler& scheduler,
                                                const transport::Endpoint& local, Callbacks calls);
};

}  // namespace rubicon::web::server
