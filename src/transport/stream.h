#pragma once

#include <cstddef>
#include <functional>

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::transport {

/// Called from the loop, never from inside a call to the stream. The stream may be destroyed in any of them.
struct StreamCalls {
  /// The line is there: bytes flow from now on. Never called for a connection that somebody else made.
  std::function<void()> connected;
  /// What came next in the stream, in pieces of any size. The bytes are only good during the call.
  std::function<void(ByteView bytes)> received;
  /// There is no connection (any more), for whatever reason, the other end's orderly close and a pulled plug among
  /// them; called once.
  std::function<void(Error)> failed;
};

/// Bytes in order to and from one other end: a TCP connection, a serial line. Destroyed = closed.
class ByteStream {
 public:
  /// Bytes that wait for a busy line, or for the connection; a send that would make them more is refused.
  static constexpr std::size_t kMaxQueued = std::size_t{64} * 1024;

  virtual ~ByteStream() = default;
  /// Hands the bytes over, or queues them while the line is busy or not yet there: all or nothing. kBusy beyond
  /// kMaxQueued, kUnreachable once the connection is lost.
  virtual Result<void> send(ByteView bytes) = 0;
  /// While held nothing is received: the other end gets no rid of its bytes, once the system's buffers are full. What
  /// is lost meanwhile may be noticed later only.
  virtual void hold(bool held) = 0;
  /// How many bytes of send() the system has not taken yet.
  virtual std::size_t queued() const = 0;
};

}  // namespace rubicon::transport
