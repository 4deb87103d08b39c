#pragma once

#include <cstdint>

// The first byte of a record (docs/recording-format.md, Records).

namespace rubicon::recording {

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

}  // namespace rubicon::recording
