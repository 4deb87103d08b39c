#pragma once

#include <chrono>

#include "base/byte_sink.h"
#include "motes/mote_packet.h"

namespace rubicon::motes {

/// Who a recorded packet came from (log.md 1): byte 8 of its record.
enum class PacketDirection : std::uint8_t { kWritten = 0, kRead = 1 };

/// One record of the original packet recorder (log.md 1): time as milliseconds since 1970, direction, length, packet,
/// big-endian. kOutOfRange for a packet longer than kMaxPacket or without its AM header: no reader finds it again.
Result<Bytes> packet_log_record(std::chrono::milliseconds time, PacketDirection direction, ByteView packet);

/// Whether records may be put behind what a file begins with: it is empty or begins with a sound record. `beginning`:
/// its first bytes, at least 21 of them if it has as many. kInvalid says what stands there instead.
Result<void> check_packet_log(ByteView beginning);

/// Writes packets exactly as the original's recorder does, each record at once. It only ever appends: give it a sink at
/// the end of a file that check_packet_log() accepts. The sink must outlive it.
class PacketLogWriter {
 public:
  explicit PacketLogWriter(base::ByteSink& sink) : sink_(sink) {}

  /// What the sink or packet_log_record() says. After an error of the sink a part of a record may stand there; readers
  /// pass over it.
  Result<void> write(std::chrono::milliseconds time, PacketDirection direction, ByteView packet);
  std::uint64_t records() const { return records_; }

 private:
  base::ByteSink& sink_;
  std::uint64_t records_ = 0;
};

}  // namespace rubicon::motes
