#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::motes {

/// CRC-16 of the serial line: polynomial 1021, not reflected, no final xor; initial value 0 (wsn.md 2; check value of
/// "123456789": 31c3). `crc`: of the preceding bytes.
std::uint16_t crc16(ByteView bytes, std::uint16_t crc = 0);

/// Protocol bytes (wsn.md 2).
inline constexpr std::uint8_t kHdlcAck = 0x43;
inline constexpr std::uint8_t kHdlcAckedPacket = 0x44;  ///< with a sequence number; asks for an acknowledgement
inline constexpr std::uint8_t kHdlcPacket = 0x45;

/// One valid frame without flags, escapes and CRC. `packet` is valid until the next call to the reader.
struct HdlcFrame {
  std::uint8_t protocol = 0;
  std::uint8_t sequence = 0;  ///< of kHdlcAck and kHdlcAckedPacket
  ByteView packet;            ///< empty for an acknowledgement
};

/// Counts of what a reader discarded.
struct HdlcFaults {
  std::uint64_t bad_crc = 0, too_short = 0, too_long = 0, broken_escapes = 0, unknown_protocols = 0,
                bytes_between = 0;  ///< before the first flag, and while searching for one

  friend bool operator==(const HdlcFaults&, const HdlcFaults&) = default;
};

/// Splits the bytes of a serial line, in pieces of any size, into frames, by the rules for the computer's side (wsn.md
/// 2): two frames may share a flag, empty frames are skipped, invalid ones are counted and discarded. Allocates
/// nothing.
class HdlcReader {
 public:
  /// Longest frame, with CRC, without escapes.
  static constexpr std::size_t kMaxFrame = 256;

  /// Consumes bytes from the front of `bytes` until a frame is complete; nullopt: all bytes were consumed before that.
  std::optional<HdlcFrame> next(ByteView& bytes);
  /// Discards a partial frame, for a line that was opened again.
  void reset();
  const HdlcFaults& faults() const { return faults_; }

 private:
  enum class State : std::uint8_t { kHunting, kInside, kEscaped, kOverlong };
  std::optional<HdlcFrame> take_flag();
  std::optional<HdlcFrame> valid_frame(ByteView frame);
  void take(std::uint8_t byte);
  ByteView take_plain_bytes(ByteView bytes);

  State state_ = State::kHunting;
  std::size_t size_ = 0;
  std::array<std::uint8_t, kMaxFrame> buffer_{};
  HdlcFaults faults_;
};

/// Frames as on the wire, with both flags (wsn.md 10: a sink loses a frame that shares one).
Bytes hdlc_ack(std::uint8_t sequence);
Bytes hdlc_acked_packet(std::uint8_t sequence, ByteView packet);  ///< computer to sink
Bytes hdlc_packet(ByteView packet);                               ///< sink to computer

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
