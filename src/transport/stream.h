#pragma once

#include <cstddef>
#include <functional>

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::transport {

/// Called from the loop, never inside a call to the stream. Each may destroy the stream.
struct StreamCalls {
  /// The line or connection is established. Not called for an accepted connection.
  std::function<void()> connected;
  /// The next bytes of the stream, in pieces of any size; valid during the call.
  std::function<void(ByteView bytes)> received;
  /// The connection failed or ended, for any reason, such as an orderly close by the other end or an unplugged device.
  /// Called once.
  std::function<void(Error)> failed;
};

/// A TCP connection or a serial line; destroying it closes it.
class ByteStream {
 public:
  /// Maximum number of bytes that wait for a busy line, or for the connection.
  static constexpr std::size_t kMaxQueued = std::size_t{64} * 1024;

  virtual ~ByteStream() = default;
  /// Sends the bytes, or queues them while the line is busy or not connected yet: all or nothing. kBusy beyond
  /// kMaxQueued, kUnreachable after the connection was lost.
  virtual Result<void> send(ByteView bytes) = 0;
  /// While held, nothing is received: when the system's buffers are full, the other end cannot send. A lost connection
  /// may be noticed only afterwards.
  virtual void hold(bool held) = 0;
  /// Bytes of send() that the system has not accepted yet.
  virtual std::size_t queued() const = 0;
};

}  // namespace rubicon::transport
