#include "networks/knx/dpt/clock_text.h"

#include <fmt/format.h>

#include <chrono>

namespace rubicon::networks::knx::dpt {

namespace {

/// `count` digits; -1 for anything else.
int digits(std::string_view text, std::size_t at, std::size_t count) {
  if (at + count > text.size()) return -1;
  int number = 0;
  for (const char c : text.substr(at, count)) {
    if (c < '0' || c > '9') return -1;
    number = number * 10 + (c - '0');
  }
  return number;
}

std::chrono::year_month_day calendar(const Clock& clock) {
  return std::chrono::year(clock.year) / clock.month / clock.day;
}

}  // namespace

bool has_date(const Clock& clock) {
  return clock.month >= 1 && clock.day >= 1 && calendar(clock).ok();
}

bool has_time(const Clock& clock) {
  if (clock.hour == 24) return clock.minute == 0 && clock.second == 0;
  return clock.hour >= 0 && clock.hour < 24 && clock.minute >= 0 && clock.minute < 60 && clock.second >= 0 &&
         clock.second < 60;
}

int weekday_of(const Clock& clock) {
  return static_cast<int>(std::chrono::weekday(std::chrono::sys_days(calendar(clock))).iso_encoding());
}

std::string clock_text(const Clock& clock) {
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", clock.year, clock.month, clock.day, clock.hour,
                     clock.minute, clock.second);
}

std::optional<Clock> parse_date(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const Clock clock{digits(text, 0, 4), digits(text, 5, 2), digits(text, 8, 2), 0, 0, 0};
  if (clock.year < 0 || !has_date(clock)) return std::nullopt;
  return clock;
}

std::optional<Clock> parse_time(std::string_view text) {
  const bool seconds = text.size() == 8;
  if ((!seconds && text.size() != 5) || text[2] != ':' || (seconds && text[5] != ':')) return std::nullopt;
  Clock clock;
  clock.hour = digits(text, 0, 2);
  clock.minute = digits(text, 3, 2);
  clock.second = seconds ? digits(text, 6, 2) : 0;
  if (!has_time(clock)) return std::nullopt;
  return clock;
}

std::optional<Clock> parse_date_time(std::string_view text) {
  if (text.size() < 11 || (text[10] != 'T' && text[10] != ' ')) return std::nullopt;
  auto clock = parse_date(text.substr(0, 10));
  const auto time = parse_time(text.substr(11));
  if (!clock || !time) return std::nullopt;
  clock->hour = time->hour;
  clock->minute = time->minute;
  clock->second = time->second;
  return clock;
}

}  // namespace rubicon::networks::knx::dpt
