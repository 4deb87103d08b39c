#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "base/bytes.h"

namespace rubicon::motes {

/// A stretch of a file that could not be read, reported once for the whole stretch.
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

/// Takes the bytes of a packet log in pieces of any size and gives its records. After damage it seeks the next sound
/// record: direction 0 or 1, length that fits the AM header inside (log.md 1.2). Holds at most one piece and a record.
class PacketLogReader {
 public:
  using Item = std::variant<PacketRecord, Damage>;

  /// Appends bytes; call next() until it gives nothing before feeding more.
  void feed(ByteView bytes);
  /// No more bytes will come: what is left is a record or damage.
  void end() { ended_ = true; }
  /// The next item, or nothing until more bytes come (or for good, after end()).
  std::optional<Item> next();

 private:
  std::optional<Item> damage_or_nothing();
  void skip_one();
  PacketRecord take_record();

  Bytes buffer_;
  std::size_t position_ = 0;
  std::uint64_t base_ = 0;  ///< file offset of buffer_[0]
  bool ended_ = false;
  std::optional<Damage> damage_;
};

}  // namespace rubicon::motes
