#include "base/clocks.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace rubicon::base {
namespace {

/// The zone of this process while it lives, in the POSIX form, which needs no files.
class Zone {
 public:
  explicit Zone(const char* zone) {
    if (const auto* before = std::getenv("TZ")) before_ = before;
    ::setenv("TZ", zone, 1);
  }
  ~Zone() { before_.empty() ? ::unsetenv("TZ") : ::setenv("TZ", before_.c_str(), 1); }
  Zone(const Zone&) = delete;
  Zone& operator=(const Zone&) = delete;

 private:
  std::string before_;
};

WallTime at(std::int64_t microseconds) {
  return WallTime(std::chrono::microseconds(microseconds));
}

constexpr auto kCentralEurope = "CET-1CEST,M3.5.0,M10.5.0/3";
constexpr std::int64_t kNewYear = 1767225600'250'000;  // 2026-01-01T00:00:00.25Z

TEST(LocalTime, PeopleReadLocalTimeWithItsZone) {
  const Zone zone(kCentralEurope);
  EXPECT_EQ(local_text(at(kNewYear)), "2026-01-01 01:00:00.250 CET");
  EXPECT_EQ(local_clock_text(at(kNewYear)), "01:00:00.250 CET");
  EXPECT_EQ(local_seconds_text(at(kNewYear)), "01:00:00 CET");
}

TEST(LocalTime, SummerTimeIsAnotherZone) {
  const Zone zone(kCentralEurope);
  EXPECT_EQ(local_clock_text(at(kNewYear + 181LL * 86400 * 1'000'000)), "02:00:00.250 CEST");
}

TEST(LocalTime, ProgramsReadTheOffset) {
  {
    const Zone zone(kCentralEurope);
    EXPECT_EQ(iso_text(at(kNewYear)), "2026-01-01T01:00:00.250000+01:00");
  }
  const Zone zone("XXX3:30");
  EXPECT_EQ(iso_text(at(kNewYear)), "2025-12-31T20:30:00.250000-03:30");
}

TEST(LocalTime, WithoutAZoneItIsUtc) {
  const Zone zone("UTC0");
  EXPECT_EQ(local_text(at(kNewYear)), "2026-01-01 00:00:00.250 UTC");
  EXPECT_EQ(iso_text(at(kNewYear)), "2026-01-01T00:00:00.250000+00:00");
}

TEST(LocalTime, TimesBefore1970AndWithoutACalendarHaveAText) {
  const Zone zone("UTC0");
  EXPECT_EQ(iso_text(at(-1)), "1969-12-31T23:59:59.999999+00:00");
  EXPECT_FALSE(local_text(WallTime::max()).empty());
  EXPECT_FALSE(iso_text(WallTime::min()).empty());
}

}  // namespace
}  // namespace rubicon::base
