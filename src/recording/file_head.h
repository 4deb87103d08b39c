#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/time.hpp"

namespace rubicon::recording {

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

}  // namespace rubicon::recording
