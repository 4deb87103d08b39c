#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::motes {

/// The greeting of the serial-forwarder protocol (wsn.md 4.1): both sides send these two bytes first, then packets,
/// each after a length byte.
inline constexpr std::array<std::uint8_t, 2> kForwarderHello{0x55, 0x20};

/// Splits the bytes of one direction of a connection, in pieces of any size, into packets. Allocates nothing.
class ForwarderReader {
 public:
  /// Consumes bytes from the front of `bytes` until a packet is complete; nullopt: all bytes were consumed before that.
  /// The packet is valid until the next call. kInvalid if the peer violates the protocol (first byte not 55, version
  /// below 20, length 0); then every later call fails too.
  Result<std::optional<ByteView>> next(ByteView& bytes);
  /// The peer's greeting was read.
  bool greeted() const { return greeting_ == kForwarderHello.size(); }

 private:
  Result<void> greet(std::uint8_t byte);

  std::size_t greeting_ = 0, wanted_ = 0, size_ = 0;
  std::optional<Error> fault_;
  std::array<std::uint8_t, 255> buffer_{};
};

/// Length byte and packet. Asserts that the packet has 1 to 255 bytes.
Bytes forwarder_packet(ByteView packet);

}  // namespace rubicon::motes
