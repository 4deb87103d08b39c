#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "rubicon/time.hpp"

namespace rubicon::recording {

/// The first bytes of every block (docs/recording-format.md, Blocks).
inline constexpr std::array<std::uint8_t, 8> kSync{0xf3, 'R', 'B', 'L', 'K', 0x0d, 0x0a, 0xc5};
inline constexpr std::size_t kBlockHead = 44;
/// A block is closed when its records have this size before compression, in bytes,
inline constexpr std::size_t kBlockSize = 256 << 10;
/// so that it is not larger than this with the longest possible last record,
inline constexpr std::size_t kMaxRaw = 2 << 20;
/// or this, if compression enlarges it.
inline constexpr std::size_t kMaxPacked = kMaxRaw + (64 << 10);
inline constexpr std::size_t kMaxBlock = kBlockHead + kMaxPacked;

struct BlockHead {
  std::uint32_t packed = 0;   ///< bytes after the head: one zstd frame
  std::uint32_t raw = 0;      ///< bytes it unpacks to
  std::uint32_t records = 0;  ///< at least 1
  WallTime first{}, last{};   ///< when its first and last record were seen
  std::uint32_t sum = 0;      ///< CRC-32C of the packed bytes
};

/// Writes kBlockHead bytes.
void encode_block_head(const BlockHead& head, std::uint8_t* to);
/// nullopt unless the bytes begin with a sound head whose lengths are within the limits.
std::optional<BlockHead> decode_block_head(ByteView bytes);
/// The length of the sound block at the beginning of these bytes; 0 if there is none.
std::size_t sound_block(ByteView bytes);

/// Offset of the first sync marker at or after `from`; bytes.size() if there is none.
std::size_t find_sync(ByteView bytes, std::size_t from);

}  // namespace rubicon::recording
