#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/time.hpp"

namespace rubicon::recording {

/// What happened to a tuple, or a mark of the recorder. The numbers are those in the file.
enum class RecordKind : std::uint8_t {
  kSet = 0,
  kDeleted = 1,
  kExpired = 2,
  /// Part of a snapshot: the tuple existed, whenever it was set.
  kPresent = 3,
  /// A mark of the recorder: the value is one of the words below, the key is empty. Readers ignore unknown words.
  kMark = 4
};
std::string_view to_string(RecordKind kind);

/// The recorder started with its island, and a new session begins. A snapshot follows.
inline constexpr std::string_view kMarkStart = "start";
/// A snapshot begins: a new file, or the first record after a gap.
inline constexpr std::string_view kMarkSnapshot = "snapshot";
/// The snapshot is complete: tuples that are not in it do not exist.
inline constexpr std::string_view kMarkComplete = "complete";
/// A user marked this moment; a text of the user may follow behind `: `.
inline constexpr std::string_view kMarkOfUser = "mark";

/// All times are within this of 1970 (about 127,000 years), so that the difference of two fits 64 bits.
inline constexpr std::chrono::microseconds kFurthest{4'000'000'000'000'000'000};

/// One record. The reader or writer that provides it defines how long the views are valid.
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
  std::uint32_t key_number = 0;  ///< of owner and key within the block, from 0; set by the reader only
};

/// Larger records, in bytes, are neither written nor read.
inline constexpr std::size_t kMaxValue = 1 << 20;
inline constexpr std::size_t kMaxKey = 255;
inline constexpr std::size_t kMaxMediaType = 255;

/// Column names of append_csv_line(), with their line end.
inline constexpr std::string_view kCsvHeader =
    "seen,event,owner,key,value,encoding,media_type,creator,sequence,write,user,expire\n";

/// Appends one field by RFC 4180, in quotation marks where that is necessary.
void append_csv_cell(std::string_view text, std::string& out);
/// A line by RFC 4180 with LF. Times are seconds since 1970 with microseconds, empty = not given. Values that are not
/// UTF-8 are in hexadecimal digits, with the encoding `hex`.
void append_csv_line(const recording::Record& record, std::string& out);
/// The same fields as JSON; binary values as `value_hex`.
void append_json_line(const recording::Record& record, std::string& out);

/// `2026-01-31 12:00:00.250000 UTC`; in seconds since 1970 for years before 1970 and after 9999.
std::string utc_text(WallTime time);

}  // namespace rubicon::recording
