#pragma once

#include <ctime>
#include <string>

#include "rubicon/time.hpp"

namespace rubicon::base {

// Times for people: local time of this process (TZ, /etc/localtime) with the name of the zone. A time outside of the
// system's calendar is written as seconds since 1970.

/// `2026-01-31 12:00:00.250 CET`, milliseconds rounded down.
std::string local_text(WallTime time);
/// `12:00:00.250 CET`.
std::string local_clock_text(WallTime time);
/// `12:00:00 CET`.
std::string local_seconds_text(WallTime time);
/// `0.3s`, `25s`, `12min`, `5h`, `3d`; `-` where `then` is zero (not known). A time in the future has the age 0.
std::string age_text(WallTime then, WallTime now);
/// For programs: ISO 8601 (RFC 3339) with the offset of the local zone, `2026-01-31T12:00:00.250000+01:00`.
std::string iso_text(WallTime time);

/// UTC in a format of strftime(3) that writes at most 63 characters, seconds rounded down.
std::string utc_text(WallTime time, const char* format);

/// Since the start of the kernel, also while it slept: the same for all processes of a host (CLOCK_BOOTTIME,
/// clock_gettime(2)).
inline Duration since_boot() {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace rubicon::base
