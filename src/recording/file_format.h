#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/time.hpp"

namespace rubicon::recording {

/// CRC-32C (Castagnoli; polynomial 1EDC6F41, reflected 82F63B78; initial value and final xor FFFFFFFF), as in RFC 3720,
/// appendix B.4.
std::uint32_t crc32c(ByteView bytes);

/// Integers in little-endian order, as in the heads of the format; the caller provides enough bytes.
template <class Number>
void put_le(std::uint8_t* to, Number number) {
  auto rest = static_cast<std::uint64_t>(number);
  for (std::size_t i = 0; i < sizeof(Number); ++i, rest >>= 8U) to[i] = static_cast<std::uint8_t>(rest);
}

template <class Number>
Number get_le(const std::uint8_t* from) {
  std::uint64_t sum = 0;
  for (std::size_t i = sizeof(Number); i-- > 0;) sum = sum << 8U | from[i];
  return static_cast<Number>(sum);
}

// The first byte of a record (docs/recording-format.md, Records).

inline constexpr std::uint8_t kKindBits = 0x07;
inline constexpr std::uint8_t kHasUserTime = 0x08;
inline constexpr std::uint8_t kHasExpireTime = 0x10;
inline constexpr std::uint8_t kHasCreator = 0x20;    ///< other than the owner
inline constexpr std::uint8_t kHasMediaType = 0x40;  ///< other than in the key's record before
inline constexpr std::uint8_t kHasSeen = 0x80;       ///< other than in the record before

/// Media type number 0 of every block; the default of a key's first record.
inline constexpr const char* kPlainText = "text/plain";

/// Signed differences as small unsigned numbers; both ways wrap, so that any two 64-bit numbers have one.
constexpr std::uint64_t zigzag(std::uint64_t difference) {
  return difference << 1U ^ (0 - (difference >> 63U));
}
constexpr std::uint64_t from_zigzag(std::uint64_t folded) {
  return folded >> 1U ^ (0 - (folded & 1U));
}

/// First bytes of every recording. The high bit and the line end reveal a file that was changed by a transfer as text.
inline constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'R', 'U', 'B', 'R', 'E', 'C', '\n'};
inline constexpr std::uint16_t kVersion = 1;
/// Magic, version and length, which every version has.
inline constexpr std::size_t kHeadStart = 12;
inline constexpr std::size_t kMaxHead = 1024;

/// The head of a recording (docs/recording-format.md, Head).
struct FileHead {
  IslandId island{};
  std::string prefix = "proxy";  ///< first part of the island's keys
  WallTime created{};            ///< of the first record
  std::string writer;            ///< program and version, informative
};

/// Cuts prefix and writer at 255 bytes.
Bytes encode_head(const FileHead& head);

enum class HeadState : std::uint8_t { kSound, kNoRecording, kIncomplete, kDamaged, kNewer };

/// The head that a file has.
struct HeadFound {
  HeadState state = HeadState::kNoRecording;
  FileHead head;
  std::size_t size = 0;  ///< of a sound head, in bytes; the blocks follow
};
/// `bytes`: the first kMaxHead bytes of a file, fewer only if it is shorter. kIncomplete: they begin like a recording,
/// but the head is not complete.
HeadFound decode_head(ByteView bytes);

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
