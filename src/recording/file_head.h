#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/time.hpp"

namespace rubicon::recording {

/// First bytes of every recording. The high bit and the line ends show a file that a text transfer has changed.
inline constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'R', 'U', 'B', 'R', 'E', 'C', '\n'};
inline constexpr std::uint16_t kVersion = 1;
/// Magic, version, length; what every version has.
inline constexpr std::size_t kHeadStart = 12;
inline constexpr std::size_t kMaxHead = 1024;

/// Whose recording it is (docs/recording-format.md, Head).
struct FileHead {
  IslandId island{};
  std::string prefix = "proxy";  ///< first part of the island's keys
  WallTime created{};            ///< of the first record
  std::string writer;            ///< program and version, for people
};

/// Prefix and writer are cut at 255 bytes.
Bytes encode_head(const FileHead& head);

enum class HeadState : std::uint8_t { kSound, kNoRecording, kIncomplete, kDamaged, kNewer };

/// What stands at the beginning of a file.
struct HeadFound {
  HeadState state = HeadState::kNoRecording;
  FileHead head;
  std::size_t size = 0;  ///< of a sound head: where the blocks begin
};
/// `bytes` are the first ones of a file, all of it if it is shorter than kMaxHead. kIncomplete: so far it looks like a
/// recording, but the head does not end in them.
HeadFound decode_head(ByteView bytes);

}  // namespace rubicon::recording
