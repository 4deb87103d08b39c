#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::transport {

/// Longest path of a socket, in bytes (unix(7): sun_path with its end).
inline constexpr std::size_t kMaxSocketPath = 107;

/// The process at the other end of a local stream when the connection began, as the kernel says: unix(7), SO_PEERCRED
/// and SO_PEERGROUPS. A user or a process that has no number here (another user or process namespace) is the overflow
/// uid, 65534, or process 0.
struct LocalPeer {
  uid_t user = 65534;
  pid_t process = 0;
  std::vector<gid_t> groups{};  ///< the first is its own group
};

/// Called from the loop, never inside a call to the stream. Each may destroy the stream.
struct LocalCalls {
  /// The next bytes, at most kMaxRead in one turn of the loop; valid during the call.
  std::function<void(ByteView bytes)> received;
  /// The system takes bytes again, after write() took less than it was given.
  std::function<void()> writable;
  /// The connection ended, for any reason. Called once, after all that the other end wrote was received.
  std::function<void(Error why)> failed;
};

/// A connection between two processes of one host; destroying it closes it. The bytes that write() took still arrive.
class LocalStream {
 public:
  static constexpr std::size_t kMaxRead = std::size_t{256} * 1024;

  virtual ~LocalStream() = default;
  /// Returns how many of the first bytes the system took. After less than all, `writable` is called once. kUnreachable:
  /// the other end is gone; `failed` follows.
  virtual Result<std::size_t> write(ByteView bytes) = 0;
  /// Bytes that write() took and the other process has not read.
  virtual std::size_t unread() const = 0;
  virtual const LocalPeer& peer() const = 0;
};

/// Receives our end of an accepted connection, and returns its calls.
using LocalAccept = std::function<LocalCalls(std::unique_ptr<LocalStream> stream)>;

/// Accepts connections until destroyed; those that were accepted stay open.
class LocalListener {
 public:
  virtual ~LocalListener() = default;
};

}  // namespace rubicon::transport
