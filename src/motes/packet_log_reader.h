#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "base/bytes.h"

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
  /// The end of the file: the remaining bytes are a record or damage.
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

}  // namespace rubicon::motes
