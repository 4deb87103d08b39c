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
  /// The attempt to connect fails after this time.
  Duration connect_timeout = std::chrono::seconds(10);
  /// The connection ends if sent bytes are not acknowledged for this long (RFC 5482); 0 = the system's default, which
  /// is minutes.
  Duration user_timeout = std::chrono::seconds(30);
  /// Interval between probes of a silent connection, in whole seconds; without answers it ends after the user timeout.
  /// 0 = no probes.
  Duration keep_alive = std::chrono::seconds(10);
};

using TcpCalls = StreamCalls;

/// A connection that is being established, or established. Destroying it closes it: bytes that the system accepted are
/// still sent, queued bytes are not. Small sends are transmitted at once (TCP_NODELAY).
class TcpStream : public ByteStream {
 public:
  virtual bool connected() const = 0;
  /// Bytes of send() that the other end's system has not acknowledged, with those of queued(); 0 after the connection
  /// was lost. It acknowledges what its buffers take, which its program may not have read.
  virtual std::size_t unacknowledged() const = 0;
  /// Aborts the connection: nothing more is sent, not even what the system accepted (RFC 9293, section 3.10.5). No
  /// calls follow; destroy the stream next.
  virtual void abort() = 0;
  /// Own address and port; empty until connected.
  virtual Endpoint local() const = 0;
  /// The other end's address and port; empty until connected.
  virtual Endpoint remote() const = 0;
};

/// Receives our end of an accepted connection, and returns its callbacks.
using TcpAccept = std::function<TcpCalls(std::unique_ptr<TcpStream> stream)>;

/// The listener cannot accept connections any longer, for good; it should be destroyed.
using ListenerFailed = std::function<void(Error)>;

/// Listens on a port until destroyed; accepted connections stay open.
class TcpListener {
 public:
  virtual ~TcpListener() = default;
  /// The bound address and port.
  virtual Endpoint local() const = 0;
};

}  // namespace rubicon::transport
