#pragma once

#include <chrono>

#include "base/byte_sink.h"
#include "motes/mote_packet.h"

namespace rubicon::motes {

/// Direction of a recorded packet (log.md 1): byte 8 of its record; kRead: the sink sent it.
enum class PacketDirection : std::uint8_t { kWritten = 0, kRead = 1 };

/// One record of the original packet recorder (log.md 1): time as milliseconds since 1970, direction, length, packet,
/// big-endian. kOutOfRange for a packet that is longer than kMaxPacket or shorter than its header: readers
/// would not recognise it.
Result<Bytes> packet_log_record(std::chrono::milliseconds time, PacketDirection direction, ByteView packet);

/// Whether records may be appended to a file: it is empty or begins with a valid record. `beginning`: its first bytes,
/// at least 21 of them if it has as many. kInvalid: it begins with something else.
Result<void> check_packet_log(ByteView beginning);

/// Writes packets as the original's recorder does, each record with one append. `sink` must be at the end of a file
/// that check_packet_log() accepts, and must outlive the writer.
class PacketLogWriter {
 public:
  explicit PacketLogWriter(base::ByteSink& sink) : sink_(sink) {}

  /// Errors of packet_log_record() and of the sink. After the latter the file may end with a partial record, which
  /// readers skip.
  Result<void> write(std::chrono::milliseconds time, PacketDirection direction, ByteView packet);
  std::uint64_t records() const { return records_; }

 private:
  base::ByteSink& sink_;
  std::uint64_t records_ = 0;
};

}  // namespace rubicon::motes
