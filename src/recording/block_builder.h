#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "recording/file_format.h"
#include "recording/record.h"

struct ZSTD_CCtx_s;

namespace rubicon::recording {

/// zstd levels. Level 9 takes 8 ms for a block of 256 KiB; level 19 would save 10 to 25 percent more, but block the
/// loop for 70 ms, and several times that on a small machine.
inline constexpr int kFastest = 1, kSmallest = 9, kUsual = 3;

/// Collects records and encodes them as one block. Memory is bounded by the size of a block.
class BlockBuilder {
 public:
  explicit BlockBuilder(int compression = kUsual);
  ~BlockBuilder();
  BlockBuilder(const BlockBuilder&) = delete;
  BlockBuilder& operator=(const BlockBuilder&) = delete;

  /// False, and the record is not added: value, key or media type is too long.
  bool add(const Record& record);
  bool empty() const { return records_ == 0; }
  /// The block should be closed.
  bool full() const { return raw_.size() >= kBlockSize; }
  std::uint32_t records() const { return records_; }
  WallTime first() const { return WallTime(std::chrono::microseconds(first_)); }
  WallTime last() const { return WallTime(std::chrono::microseconds(seen_)); }

  /// Encodes the records; the bytes are valid until the next call, and the builder is empty. Must not be called while
  /// it is empty.
  ByteView close();
  /// Discards the records.
  void clear();

 private:
  /// A key of an owner in this block.
  struct Known {
    std::size_t hash = 0;
    std::uint32_t at = 0;  ///< of the key's text in raw_
    std::uint32_t owner = 0;
    std::uint64_t sequence = 0;
    std::uint16_t size = 0;
    std::uint16_t media_type = 0;
  };

  std::uint32_t find(std::size_t hash, std::uint32_t owner, std::string_view key) const;
  void remember(const Known& known);
  void grow_table();
  std::uint8_t* put_media_type(std::uint8_t* to, Known& known, std::string_view name);

  int compression_;
  std::unique_ptr<ZSTD_CCtx_s, void (*)(ZSTD_CCtx_s*)> packer_;
  Bytes raw_, block_;
  std::vector<Known> keys_;
  std::vector<std::uint32_t> table_;  ///< open addressing: number of the key + 1, 0 = free
  std::vector<std::string> media_types_;
  std::uint32_t records_ = 0;
  std::int64_t first_ = 0;
  std::int64_t seen_ = 0;
};

}  // namespace rubicon::recording
