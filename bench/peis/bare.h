#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace rubicon::bench::peis {

/// A TCP connection on loopback without anything else, in blocking calls. Throws if a call fails.
class BareConnection {
 public:
  /// Waits for the other process, at most 10 s.
  static BareConnection connect();
  static BareConnection accept();
  BareConnection(BareConnection&& other) noexcept;
  BareConnection& operator=(BareConnection&&) = delete;
  ~BareConnection();

  void send(const std::vector<std::uint8_t>& bytes);
  /// Fills the buffer. False: the other end closed.
  bool receive(std::vector<std::uint8_t>& bytes);
  /// Whatever is there, at most that many. 0: the other end closed.
  std::size_t receive_some(std::vector<std::uint8_t>& bytes);

 private:
  explicit BareConnection(int socket);

  int socket_;
};

}  // namespace rubicon::bench::peis
