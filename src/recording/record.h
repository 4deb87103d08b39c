#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/time.hpp"

namespace rubicon::recording {

/// What happened to a tuple, or what the recorder itself did. The numbers are those of the file.
enum class RecordKind : std::uint8_t {
  kSet = 0,
  kDeleted = 1,
  kExpired = 2,
  /// Part of a snapshot: the tuple was there, whenever it was set.
  kPresent = 3,
  /// A word of the recorder, in the value; the key is empty. Readers pass over words they do not know.
  kMark = 4
};
std::string_view to_string(RecordKind kind);

/// The recorder began with its island: what was recorded before is over. A snapshot follows.
inline constexpr std::string_view kMarkStart = "start";
/// A snapshot begins: a new file, or the first record after a gap.
inline constexpr std::string_view kMarkSnapshot = "snapshot";
/// The snapshot is complete: what it did not name is not there.
inline constexpr std::string_view kMarkComplete = "complete";

/// No record has a time further from 1970 than this (about 127,000 years), so that the difference of any two fits.
inline constexpr std::chrono::microseconds kFurthest{4'000'000'000'000'000'000};

/// One line of a recording. The views are valid during the call that hands it over.
struct Record {
  RecordKind kind = RecordKind::kSet;
  WallTime seen{};  ///< when the recorder saw it
  OwnerId owner{};
  std::string_view key;
  std::string_view value;
  std::string_view media_type;
  OwnerId creator{};
  std::uint64_t sequence = 0;
  WallTime write_time{};
  WallTime user_time{};          ///< zero = not given
  WallTime expire_time{};        ///< zero = never
  std::uint32_t key_number = 0;  ///< of owner and key among those of its block, from 0; set by the reader only
};

/// What does not fit these bounds is not recorded (and no reader takes it).
inline constexpr std::size_t kMaxValue = 1 << 20;
inline constexpr std::size_t kMaxKey = 255;
inline constexpr std::size_t kMaxMediaType = 255;

}  // namespace rubicon::recording
