#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace rubicon::networks::knx::dpt {

/// A date and a time of day without a zone, as buses send them.
struct Clock {
  int year = 2000, month = 1, day = 1, hour = 0, minute = 0, second = 0;
};

/// One part of it and what its octet of 19.001 can hold (KNX 3/7/2).
struct ClockPart {
  std::string_view name;
  int Clock::*value = nullptr;
  int minimum = 0, maximum = 0;
};
inline constexpr ClockPart kClockParts[] = {{"year", &Clock::year, 1900, 2155}, {"month", &Clock::month, 0, 15},
                                            {"day", &Clock::day, 0, 31},        {"hour", &Clock::hour, 0, 31},
                                            {"minute", &Clock::minute, 0, 63},  {"second", &Clock::second, 0, 63}};

/// Whether the date is in the calendar.
bool has_date(const Clock& clock);
/// Below 24:00:00, or just that.
bool has_time(const Clock& clock);
/// 1 = Monday .. 7 = Sunday; of a date in the calendar.
int weekday_of(const Clock& clock);

/// `2026-11-20T13:30:15`
std::string clock_text(const Clock& clock);
/// `2026-11-20T13:30:15`, also with a blank for the T and without seconds; nullopt for any other text.
std::optional<Clock> parse_date_time(std::string_view text);
/// `2026-11-20`
std::optional<Clock> parse_date(std::string_view text);
/// `13:30:15` or `13:30`
std::optional<Clock> parse_time(std::string_view text);

}  // namespace rubicon::networks::knx::dpt
