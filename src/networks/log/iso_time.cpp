#include "networks/log/iso_time.h"

#include "base/text.h"

namespace rubicon::networks::log {

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
