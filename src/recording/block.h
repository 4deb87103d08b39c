#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "rubicon/time.hpp"

namespace rubicon::recording {

/// Every block begins so (docs/recording-format.md, Blocks).
inline constexpr std::array<std::uint8_t, 8> kSync{0xf3, 'R', 'B', 'L', 'K', 0x0d, 0x0a, 0xc5};
inline constexpr std::size_t kBlockHead = 44;
/// A block is closed when its records take this much before compression...
inline constexpr std::size_t kBlockSize = 256 << 10;
/// ...so that with the longest possible last record none is longer than this.
inline constexpr std::size_t kMaxRaw = 2 << 20;
/// What compression can make of it at worst.
inline constexpr std::size_t kMaxPacked = kMaxRaw + (64 << 10);
inline constexpr std::size_t kMaxBlock = kBlockHead + kMaxPacked;

struct BlockHead {
  std::uint32_t packed = 0;   ///< bytes behind the head: one zstd frame
  std::uint32_t raw = 0;      ///< bytes it unpacks to
  std::uint32_t records = 0;  ///< at least 1
  WallTime first{}, last{};   ///< when its first and last record were seen
  std::uint32_t sum = 0;      ///< CRC-32C of the packed bytes
};

/// Writes kBlockHead bytes.
void encode_block_head(const BlockHead& head, std::uint8_t* to);
/// Nothing unless the bytes begin with a sound head whose lengths are within the bounds.
std::optional<BlockHead> decode_block_head(ByteView bytes);
/// Whether a whole sound block stands at the beginning of these bytes; its length, else 0.
std::size_t sound_block(ByteView bytes);

/// Offset of the first sync marker at or behind `from`; bytes.size() if there is none.
std::size_t find_sync(ByteView bytes, std::size_t from);

}  // namespace rubicon::recording
