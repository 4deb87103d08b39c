#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/bytes.h"

namespace rubicon::motes {

/// CRC-16 of the serial line: polynomial 1021, not reflected, no final xor; begins with 0 (wsn.md 2; check value of
/// "123456789": 31c3). `crc`: of the bytes before these.
std::uint16_t crc16(ByteView bytes, std::uint16_t crc = 0);

/// Protocol bytes (wsn.md 2).
inline constexpr std::uint8_t kHdlcAck = 0x43;
inline constexpr std::uint8_t kHdlcAckedPacket = 0x44;  ///< with a sequence number; wants an ack
inline constexpr std::uint8_t kHdlcPacket = 0x45;

/// One sound frame without flags, escapes and CRC. `packet` is good until the reader is used again.
struct HdlcFrame {
  std::uint8_t protocol = 0;
  std::uint8_t sequence = 0;  ///< of kHdlcAck and kHdlcAckedPacket
  ByteView packet;            ///< empty for an ack
};

/// What a reader passed over.
struct HdlcFaults {
  std::uint64_t bad_crc = 0, too_short = 0, too_long = 0, broken_escapes = 0, unknown_protocols = 0,
                bytes_between = 0;  ///< before the first flag, and while in search of one

  friend bool operator==(const HdlcFaults&, const HdlcFaults&) = default;
};

/// Bytes of a serial line, in pieces of any size -> frames, by the rules for the computer's side (wsn.md 2): flags may
/// be shared, empty frames are skipped, whatever is unsound is counted and dropped. Allocates nothing.
class HdlcReader {
 public:
  /// Longest frame, CRC included, without escapes.
  static constexpr std::size_t kLongest = 256;

  /// Takes bytes from the front of `bytes` until a frame is complete; nullopt: all were taken, no frame is.
  std::optional<HdlcFrame> next(ByteView& bytes);
  /// The line was closed and opened: what was begun is forgotten.
  void reset();
  const HdlcFaults& faults() const { return faults_; }

 private:
  enum class Place : std::uint8_t { kHunting, kInside, kEscaped, kOverlong };
  std::optional<HdlcFrame> flag();
  std::optional<HdlcFrame> sound_frame(ByteView frame);
  void take(std::uint8_t byte);
  ByteView plain_run(ByteView bytes);

  Place place_ = Place::kHunting;
  std::size_t size_ = 0;
  std::array<std::uint8_t, kLongest> buffer_{};
  HdlcFaults faults_;
};

/// Frames as they stand on the wire, with both flags (wsn.md 10: a sink loses a frame that shares one).
Bytes hdlc_ack(std::uint8_t sequence);
Bytes hdlc_acked_packet(std::uint8_t sequence, ByteView packet);  ///< computer to sink
Bytes hdlc_packet(ByteView packet);                               ///< sink to computer

}  // namespace rubicon::motes
