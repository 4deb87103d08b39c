#include "networks/zigbee/device/last_seen.h"

#include "base/text.h"

namespace rubicon::networks::zigbee::device {

namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::minutes;

/// The end of the year 2199: ages in nanoseconds reach no further than 292 years.
constexpr WallTime kLatest{milliseconds(7'258'118'399'999)};

/// Takes a number of exactly `digits` digits from the front.
std::optional<int> take_number(std::string_view& text, std::size_t digits) {
  if (text.size() < digits || text.find_first_not_of("0123456789") < digits) return std::nullopt;
  const auto number = base::parse_number<int>(text.substr(0, digits));
  text.remove_prefix(digits);
  return number;
}

bool take(std::string_view& text, char wanted) {
  if (text.empty() || text.front() != wanted) return false;
  text.remove_prefix(1);
  return true;
}

std::optional<WallTime> take_date(std::string_view& text) {
  const auto year = take_number(text, 4);
  if (!year || !take(text, '-')) return std::nullopt;
  const auto month = take_number(text, 2);
  if (!month || !take(text, '-')) return std::nullopt;
  const auto day = take_number(text, 2);
  if (!day || !take(text, 'T')) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok() || *year < 1970) return std::nullopt;
  return WallTime(std::chrono::sys_days(date));
}

std::optional<microseconds> take_clock(std::string_view& text) {
  const auto hour = take_number(text, 2);
  if (!hour || *hour > 23 || !take(text, ':')) return std::nullopt;
  const auto minute = take_number(text, 2);
  if (!minute || *minute > 59 || !take(text, ':')) return std::nullopt;
  const auto second = take_number(text, 2);
  if (!second || *second > 59) return std::nullopt;
  microseconds clock = std::chrono::hours(*hour) + minutes(*minute) + std::chrono::seconds(*second);
  if (!take(text, '.')) return clock;
  microseconds unit = std::chrono::seconds(1);
  while (!text.empty() && text.front() >= '0' && text.front() <= '9') {
    unit /= 10;
    clock += unit * (text.front() - '0');
    text.remove_prefix(1);
  }
  return clock;
}

/// `Z`, `+01:00` or `+0100`.
std::optional<minutes> take_offset(std::string_view& text) {
  if (take(text, 'Z')) return minutes(0);
  const bool west = take(text, '-');
  if (!west && !take(text, '+')) return std::nullopt;
  const auto hour = take_number(text, 2);
  if (!hour) return std::nullopt;
  take(text, ':');
  const auto minute = take_number(text, 2);
  if (!minute || *minute > 59) return std::nullopt;
  const minutes offset = std::chrono::hours(*hour) + minutes(*minute);
  return west ? -offset : offset;
}

}  // namespace

std::optional<WallTime> read_last_seen(std::string_view json) {
  if (const auto epoch = base::parse_number<std::int64_t>(json)) {
    if (*epoch <= 0 || *epoch > kLatest.time_since_epoch() / milliseconds(1)) return std::nullopt;
    return WallTime(milliseconds(*epoch));
  }
  if (json.size() < 2 || !take(json, '"') || json.back() != '"') return std::nullopt;
  json.remove_suffix(1);
  const auto date = take_date(json);
  const auto clock = date ? take_clock(json) : std::nullopt;
  const auto offset = clock ? take_offset(json) : std::nullopt;
  if (!offset || !json.empty()) return std::nullopt;
  const auto time = *date + *clock - *offset;
  return time <= kLatest ? std::optional(time) : std::nullopt;
}

}  // namespace rubicon::networks::zigbee::device
