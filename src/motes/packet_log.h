#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "base/bytes.h"
#include "motes/mote_packet.h"

namespace rubicon::motes {

/// Consecutive bytes of a file that could not be decoded, reported once.
struct Damage {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::string why;
};

/// One record of the original packet recorder (log.md 1).
struct PacketRecord {
  std::uint64_t offset = 0;
  std::chrono::milliseconds time{};  ///< since 1970, as written
  bool from_sink = false;            ///< direction 01; 00 = written to the sink
  Bytes packet;
};

/// Splits a packet log, fed in pieces of any size, into its records. After damage it seeks the next valid record:
/// direction 0 or 1, length that matches the AM header (log.md 1.2). Buffers at most one piece and a record.
class PacketLogReader {
 public:
  using Item = std::variant<PacketRecord, Damage>;

  /// Appends bytes; before that, call next() until it returns nullopt.
  void feed(ByteView bytes);
  /// The file ends here: the remaining bytes are a record or damage.
  void end() { ended_ = true; }
  /// The next item; nullopt until more bytes are fed, or at the end of the file.
  std::optional<Item> next();

 private:
  std::optional<Item> damage_or_nothing();
  void skip_one();
  PacketRecord take_record();

  Bytes buffer_;
  std::size_t position_ = 0;
  std::uint64_t buffer_offset_ = 0;  ///< file offset of buffer_[0]
  bool ended_ = false;
  std::optional<Damage> damage_;
};

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
