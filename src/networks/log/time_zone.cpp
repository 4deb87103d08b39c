#include "networks/log/time_zone.h"

#include <absl/time/time.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace rubicon::networks::log {

namespace {

/// Microseconds since 1970 of the year 9999, so that differences and offsets are numbers too.
constexpr std::int64_t kFurthest = 253'402'300'799'000'000;
constexpr std::array<std::string_view, 4> kOffsets{"%z", "%Ez", "%E*z", "%s"};

}  // namespace

struct TimeZone::Zone {
  absl::TimeZone zone;
};

Result<TimeZone> TimeZone::load(const std::string& name) {
  auto zone = std::make_shared<Zone>();
  if (!absl::LoadTimeZone(name, &zone->zone))
    return fail(ErrorCode::kNotFound, fmt::format("no time zone `{}` in /usr/share/zoneinfo (package tzdata), expected "
                                                  "a name such as Europe/Berlin",
                                                  name));
  return TimeZone(std::move(zone));
}

WallTime TimeZone::moment_of(WallTime local, std::optional<WallTime> previous) const {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(local);
  const auto civil =
      absl::ToCivilSecond(absl::FromUnixSeconds(seconds.time_since_epoch().count()), absl::UTCTimeZone());
  const auto found = zone_->zone.At(civil);
  const auto wall = [&](absl::Time time) {
    return WallTime(std::chrono::seconds(absl::ToUnixSeconds(time))) + (local - seconds);
  };
  const bool second = found.kind == absl::TimeZone::TimeInfo::REPEATED && previous && wall(found.pre) < *previous;
  return wall(second ? found.post : found.pre);
}

std::optional<FileTime> parse_time(std::string_view format, std::string_view text) {
  absl::Time time;
  if (!absl::ParseTime({format.data(), format.size()}, {text.data(), text.size()}, absl::UTCTimeZone(), &time, nullptr))
    return std::nullopt;
  const auto microseconds = absl::ToUnixMicros(time);
  if (microseconds > kFurthest || microseconds < -kFurthest) return std::nullopt;
  const bool has_offset = std::any_of(kOffsets.begin(), kOffsets.end(),
                                      [&](std::string_view one) { return format.find(one) != format.npos; });
  return FileTime{WallTime(std::chrono::microseconds(microseconds)), !has_offset};
}

}  // namespace rubicon::networks::log
