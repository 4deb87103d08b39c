#pragma once

#include <chrono>
#include <cstddef>
#include <functional>

#include "base/bytes.h"
#include "base/result.h"
#include "base/time.h"
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

/// Called from the loop, never from inside a call to the stream. The stream may be destroyed in any of them.
struct TcpCalls {
  std::function<void()> connected;
  /// What came next in the stream, in pieces of any size. The bytes are only good during the call.
  std::function<void(ByteView bytes)> received;
  /// There is no connection (any more), for whatever reason, the other end's orderly close among them; called once.
  std::function<void(Error)> failed;
};

/// A connection to somebody who listens, being made or made. Destroyed = closed; what the system took by then still
/// goes out, what was queued does not. Small sends leave at once (TCP_NODELAY).
class TcpStream {
 public:
  /// Bytes that wait for a busy line, or for the connection; a send that would make them more is refused.
  static constexpr std::size_t kMaxQueued = std::size_t{64} * 1024;

  virtual ~TcpStream() = default;
  /// Hands the bytes over, or queues them while the line is busy or not yet there: all or nothing. kBusy beyond
  /// kMaxQueued, kUnreachable once the connection is lost.
  virtual Result<void> send(ByteView bytes) = 0;
  virtual bool connected() const = 0;
  /// Breaks the connection off: nothing more goes out, not even what the system took (RFC 9293, section 3.10.5). To be
  /// destroyed next; no calls.
  virtual void abort() = 0;
  /// Own address and port; empty until connected.
  virtual Endpoint local() const = 0;
};

}  // namespace rubicon::transport
