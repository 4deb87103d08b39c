#include "networks/log/file_time.h"

#include <absl/time/time.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"

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

namespace {

/// Takes exactly `digits` decimal digits from the front.
bool take_number(std::string_view& text, std::size_t digits, int& number) {
  if (text.size() < digits || text.front() == '-') return false;
  const auto parsed = base::parse_number<int>(text.substr(0, digits));
  if (!parsed) return false;
  number = *parsed;
  text.remove_prefix(digits);
  return true;
}

bool take_sign(std::string_view& text, std::string_view any_of) {
  if (text.empty() || any_of.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

/// `.25` -> 250 ms; digits beyond microseconds are ignored.
std::optional<std::chrono::microseconds> take_fraction(std::string_view& text) {
  std::chrono::microseconds fraction{0};
  if (!take_sign(text, ".,")) return fraction;
  int weight = 100'000;
  bool any = false;
  while (!text.empty() && text.front() >= '0' && text.front() <= '9') {
    fraction += std::chrono::microseconds((text.front() - '0') * weight);
    weight /= 10;
    text.remove_prefix(1);
    any = true;
  }
  if (!any) return std::nullopt;
  return fraction;
}

/// `Z`, `+01:00`, `-0530` or nothing.
std::optional<std::chrono::minutes> take_zone(std::string_view& text) {
  if (text.empty() || take_sign(text, "Zz")) return std::chrono::minutes{0};
  const int sign = text.front() == '-' ? -1 : 1;
  int hours = 0, minutes = 0;
  if (!take_sign(text, "+-") || !take_number(text, 2, hours)) return std::nullopt;
  take_sign(text, ":");
  if (!take_number(text, 2, minutes) || hours > 23 || minutes > 59) return std::nullopt;
  return sign * (std::chrono::hours(hours) + std::chrono::minutes(minutes));
}

}  // namespace

std::optional<FileTime> parse_iso_time(std::string_view text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  if (!take_number(text, 4, year) || !take_sign(text, "-") || !take_number(text, 2, month) || !take_sign(text, "-") ||
      !take_number(text, 2, day))
    return std::nullopt;
  std::chrono::microseconds fraction{0};
  if (take_sign(text, "Tt ")) {
    if (!take_number(text, 2, hour) || !take_sign(text, ":") || !take_number(text, 2, minute)) return std::nullopt;
    if (take_sign(text, ":")) {
      if (!take_number(text, 2, second)) return std::nullopt;
      const auto parsed = take_fraction(text);
      if (!parsed) return std::nullopt;
      fraction = *parsed;
    }
  }
  const bool is_local = text.empty();
  if (text.starts_with(" +") || text.starts_with(" -")) text.remove_prefix(1);
  const auto zone = take_zone(text);
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!zone || !text.empty() || !date.ok() || minute > 59 || second > 60) return std::nullopt;
  if (hour > 24 || (hour == 24 && (minute > 0 || second > 0))) return std::nullopt;
  const auto time = std::chrono::sys_days(date) + std::chrono::hours(hour) + std::chrono::minutes(minute) +
                    std::chrono::seconds(second) + fraction - *zone;
  return FileTime{time, is_local};
}

}  // namespace rubicon::networks::log
