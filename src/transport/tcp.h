#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "rubicon/time.hpp"
#include "transport/stream.h"
#include "transport/udp.h"

namespace rubicon::transport {

struct TcpOptions {
  /// Numeric address and port to connect to; names are looked up before (Transports::look_up).
  Endpoint remote;
  /// A connection that does not come about within this time has failed.
  Duration connect_timeout = std::chrono::seconds(10);
  /// Bytes that the other end does not acknowledge for so long end the connection (RFC 5482); 0 = the system's
  /// (minutes).
  Duration user_timeout = std::chrono::seconds(30);
  /// A silent connection is probed each so often, and ends with the user timeout; whole seconds; 0 = never.
  Duration keep_alive = std::chrono::seconds(10);
};

using TcpCalls = StreamCalls;

/// A connection to somebody who listens, being made or made. Destroyed = closed; what the system took by then still
/// goes out, what was queued does not. Small sends leave at once (TCP_NODELAY).
class TcpStream : public ByteStream {
 public:
  virtual bool connected() const = 0;
  /// Breaks the connection off: nothing more goes out, not even what the system took (RFC 9293, section 3.10.5). To be
  /// destroyed next; no calls.
  virtual void abort() = 0;
  /// Own address and port; empty until connected.
  virtual Endpoint local() const = 0;
  /// The other end's address and port; empty until connected.
  virtual Endpoint remote() const = 0;
};

/// Gets our end of a connection that somebody made, and says which calls it makes.
using TcpAccept = std::function<TcpCalls(std::unique_ptr<TcpStream> stream)>;

/// Nobody can connect any more (never told of what passes); the listener is to be destroyed.
using TcpDeaf = std::function<void(Error)>;

/// A port on which others connect, until this is destroyed; connections that were accepted live on.
class TcpListener {
 public:
  virtual ~TcpListener() = default;
  /// What was bound, with the port the system chose.
  virtual Endpoint local() const = 0;
};

}  // namespace rubicon::transport
