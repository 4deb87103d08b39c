#pragma once

#include <chrono>

namespace rubicon::transport {

/// The library closes its socket right after the DISCONNECT. If bytes of the broker were not read by then, the system
/// resets the connection, and the broker never sees the DISCONNECT. With a second descriptor the connection stays until
/// the broker closes it.
class KeptSocket {
 public:
  /// Of the library's socket.
  explicit KeptSocket(int socket);
  ~KeptSocket();
  KeptSocket(const KeptSocket&) = delete;
  KeptSocket& operator=(const KeptSocket&) = delete;

  /// Ends our direction, and reads until the broker ends the other.
  void await_end(std::chrono::steady_clock::time_point latest) const;

 private:
  int descriptor_;
};

/// mosquitto leaves Nagle's algorithm on: it holds a small message back until the one before is acknowledged, and the
/// system delays that by 40 ms on a connection that also sends.
void acknowledge_now(int socket);

/// The other side ended the connection, and nothing waits to be read.
bool is_ended(int socket);

}  // namespace rubicon::transport
