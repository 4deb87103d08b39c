#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::networks::log {

/// A time in a file: a moment, or what a clock on a wall showed, where the file names no offset from UTC.
struct FileTime {
  WallTime time{};
  bool is_local = false;
};

/// A zone of the IANA database, as /usr/share/zoneinfo of the system has it.
class TimeZone {
 public:
  /// `Europe/Berlin`. kNotFound: the system has no such zone.
  static Result<TimeZone> load(const std::string& name);

  /// The moment of a local time. A time in the hour that clocks repeat means the first one, unless that is before
  /// `previous`; then it means the second. In the hour that they leave out: as if they had not been set yet.
  WallTime moment_of(WallTime local, std::optional<WallTime> previous) const;

 private:
  struct Zone;
  explicit TimeZone(std::shared_ptr<const Zone> zone) : zone_(std::move(zone)) {}
  std::shared_ptr<const Zone> zone_;
};

/// Reads a time by a format of absl::ParseTime: the conversions of strptime(3), `%E*S` for seconds with a fraction and
/// `%z` for the offset; without `%z` it is local. nullopt: not of this form.
std::optional<FileTime> parse_time(std::string_view format, std::string_view text);

/// `2026-01-31T12:00:00.25Z`. A blank may replace the T, `+01:00` (after a blank or not) the Z; seconds and time may be
/// missing; `24:00` ends a day. Local without a zone.
std::optional<FileTime> parse_iso_time(std::string_view text);

}  // namespace rubicon::networks::log
