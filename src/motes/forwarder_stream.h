#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::motes {

/// The serial-forwarder protocol (wsn.md 4.1): both sides greet with these two bytes, then send packets behind a length
/// byte.
inline constexpr std::array<std::uint8_t, 2> kForwarderHello{0x55, 0x20};

/// Bytes of one direction of a connection, in pieces of any size -> packets. Allocates nothing.
class ForwarderReader {
 public:
  /// Takes bytes from the front of `bytes` until a packet is complete; nullopt: all were taken, no packet is. The
  /// packet is good until the reader is used again. kInvalid for a peer that does not speak the protocol (first byte
  /// not 55, a version before 20, a length of 0): from then on every call says so.
  Result<std::optional<ByteView>> next(ByteView& bytes);
  /// The peer's greeting was read.
  bool greeted() const { return greeting_ == kForwarderHello.size(); }

 private:
  Result<void> greet(std::uint8_t byte);

  std::size_t greeting_ = 0, wanted_ = 0, size_ = 0;
  std::optional<Error> fault_;
  std::array<std::uint8_t, 255> buffer_{};
};

/// Length byte and packet. The packet has 1 to 255 bytes: asserted.
Bytes forwarder_packet(ByteView packet);

}  // namespace rubicon::motes
