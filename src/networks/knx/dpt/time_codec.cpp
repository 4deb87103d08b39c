#include <fmt/format.h>

#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "model/json_text.h"
#include "networks/knx/dpt/codec.h"

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

namespace {

using Tree = nlohmann::ordered_json;

/// The flags of 19.001: their place in octets 6 and 7, and their values for a time without flags: working day unknown,
/// clock synchronised (KNX 3/7/2; knx.md 9.5).
struct ClockFlag {
  std::string_view name;
  std::uint8_t bit = 0;  ///< from the first bit of octet 6
  bool inverse = false;
  bool usual = false;
};
constexpr ClockFlag kFlags[] = {{"fault", 0},
                                {"workingDay", 1},
                                {"workingDayValid", 2, true, false},
                                {"yearValid", 3, true, true},
                                {"dateValid", 4, true, true},
                                {"weekdayValid", 5, true, true},
                                {"timeValid", 6, true, true},
                                {"summerTime", 7},
                                {"externalSync", 8, false, true},
                                {"reliableSource", 9}};
constexpr std::size_t kFlagsAt = 48;

bool flag_of(ByteView bytes, const ClockFlag& flag) {
  return (bits_at(bytes, kFlagsAt + flag.bit, 1) != 0) != flag.inverse;
}

void put_flag(Bytes& bytes, const ClockFlag& flag, bool on) {
  put_bits(bytes, kFlagsAt + flag.bit, 1, on != flag.inverse ? 1 : 0);
}

bool flag_of(ByteView bytes, std::string_view name) {
  for (const auto& flag : kFlags) {
    if (flag.name == name) return flag_of(bytes, flag);
  }
  return false;
}

Clock clock_of(ByteView bytes) {
  return {static_cast<int>(bytes[0]) + 1900,
          bytes[1] & 0x0f,
          bytes[2] & 0x1f,
          bytes[3] & 0x1f,
          bytes[4] & 0x3f,
          bytes[5] & 0x3f};
}

Bytes bytes_of(const Clock& clock, int weekday) {
  Bytes bytes{static_cast<std::uint8_t>(clock.year - 1900),
              static_cast<std::uint8_t>(clock.month),
              static_cast<std::uint8_t>(clock.day),
              static_cast<std::uint8_t>(weekday << 5 | clock.hour),
              static_cast<std::uint8_t>(clock.minute),
              static_cast<std::uint8_t>(clock.second),
              0,
              0};
  for (const auto& flag : kFlags) put_flag(bytes, flag, flag.usual);
  return bytes;
}

tl::unexpected<Error> no_time(const Dpt& type, ByteView bytes) {
  return fail(ErrorCode::kOutOfRange, fmt::format("{}: {} is not a date or time", name_of(type), base::to_hex(bytes)));
}

Result<Value> decode_clock(const Dpt& type, ByteView bytes) {
  const auto clock = clock_of(bytes);
  const int weekday = bytes[3] >> 5;
  const bool complete = has_date(clock) && has_time(clock);
  if (flag_of(bytes, "timeValid") && !has_time(clock)) return no_time(type, bytes);
  if (flag_of(bytes, "dateValid") && flag_of(bytes, "yearValid") && !has_date(clock)) return no_time(type, bytes);
  Tree json;
  if (complete) {
    json["dateTime"] = clock_text(clock);
  } else {
    for (const auto& part : kClockParts) json[std::string(part.name)] = clock.*part.value;
  }
  if (!complete || weekday != weekday_of(clock)) json["weekday"] = weekday;
  for (const auto& flag : kFlags) {
    if (flag_of(bytes, flag) != flag.usual) json[std::string(flag.name)] = !flag.usual;
  }
  if (complete && json.size() == 1) return Value(clock_text(clock));
  return Value(Json{model::dump(json)});
}

/// The members of the JSON form, each with the range of its field, which also holds values that are not a time.
Result<Clock> clock_parts(const Dpt& type, const Tree& json) {
  Clock clock;
  for (const auto& part : kClockParts) {
    const auto found = json.find(std::string(part.name));
    const bool there = found != json.end() && found->is_number_integer();
    const auto number = there ? found->get<std::int64_t>() : -1;
    if (number < part.minimum || number > part.maximum) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: {}: expected dateTime, or a number from {} to {}",
                                                   name_of(type), part.name, part.minimum, part.maximum));
    }
    clock.*part.value = static_cast<int>(number);
  }
  return clock;
}

Result<Clock> clock_in(const Dpt& type, const Tree& json) {
  const auto text = json.find("dateTime");
  if (text == json.end()) return clock_parts(type, json);
  const auto clock = text->is_string() ? parse_date_time(text->get<std::string>()) : std::nullopt;
  if (!clock) return fail(ErrorCode::kInvalid, name_of(type) + ": dateTime: expected 2026-11-20T13:30:15");
  return *clock;
}

Result<void> set_flags(const Dpt& type, const Tree& json, Bytes& bytes) {
  for (const auto& flag : kFlags) {
    const auto found = json.find(std::string(flag.name));
    if (found == json.end()) continue;
    if (!found->is_boolean()) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: {}: expected true or false", name_of(type), flag.name));
    }
    put_flag(bytes, flag, found->get<bool>());
  }
  const auto weekday = json.find("weekday");
  if (weekday == json.end()) return {};
  const auto number = weekday->is_number_integer() ? weekday->get<std::int64_t>() : -1;
  if (number < 0 || number > 7) return fail(ErrorCode::kInvalid, name_of(type) + ": weekday: expected 0 to 7");
  put_bits(bytes, 24, 3, static_cast<std::uint64_t>(number));
  return {};
}

Result<wire::Payload> encode_clock_json(const Dpt& type, const std::string& text) {
  const auto json = text.size() > kMaxJson ? Tree() : model::parse_ordered_json(text);
  if (!json.is_object()) return wrong_kind(type, text, "a date and time as JSON");
  const auto clock = clock_in(type, json);
  if (!clock) return fail(clock.error());
  auto bytes = bytes_of(*clock, has_date(*clock) ? weekday_of(*clock) : 0);
  if (auto set = set_flags(type, json, bytes); !set) return fail(set.error());
  const bool dated = flag_of(bytes, "dateValid") && flag_of(bytes, "yearValid");
  if ((dated && !has_date(*clock)) || (flag_of(bytes, "timeValid") && !has_time(*clock))) return no_time(type, bytes);
  return wire::Payload{std::move(bytes), false};
}

Result<wire::Payload> encode_clock(const Dpt& type, const Value& value) {
  if (const auto* json = std::get_if<Json>(&value)) return encode_clock_json(type, json->text);
  const auto* text = std::get_if<std::string>(&value);
  if (!text) return wrong_kind(type, value, "a date and time as in 2026-11-20T13:30:15");
  if (text->starts_with('{')) return encode_clock_json(type, *text);
  const auto clock = parse_date_time(*text);
  if (!clock) return wrong_kind(type, value, "a date and time as in 2026-11-20T13:30:15");
  if (clock->year < 1900 || clock->year > 2155) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} is out of range, expected 1900 to 2155", name_of(type), clock->year));
  }
  return wire::Payload{bytes_of(*clock, weekday_of(*clock)), false};
}

constexpr std::array<std::string_view, 8> kDays{"", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"};

Result<Value> decode_time_of_day(const Dpt& type, ByteView bytes) {
  Clock clock;
  clock.hour = bytes[0] & 0x1f;
  clock.minute = bytes[1] & 0x3f;
  clock.second = bytes[2] & 0x3f;
  if (!has_time(clock) || clock.hour == 24) return no_time(type, bytes);
  const auto day = kDays[bytes[0] >> 5];
  return Value(
      fmt::format("{}{}{:02}:{:02}:{:02}", day, day.empty() ? "" : " ", clock.hour, clock.minute, clock.second));
}

Result<wire::Payload> encode_time_of_day(const Dpt& type, const std::string& text) {
  const auto blank = text.find(' ');
  const auto word = blank == text.npos ? std::string_view() : std::string_view(text).substr(0, blank);
  std::size_t day = 0;
  while (day < kDays.size() && !same_word(word, kDays[day])) ++day;
  const auto clock = parse_time(std::string_view(text).substr(blank == text.npos ? 0 : blank + 1));
  if (day == kDays.size() || !clock || clock->hour == 24) {
    return wrong_kind(type, text, "a time as in 13:30:15 or Fri 13:30:15");
  }
  return wire::Payload{{static_cast<std::uint8_t>(day << 5 | static_cast<std::size_t>(clock->hour)),
                        static_cast<std::uint8_t>(clock->minute), static_cast<std::uint8_t>(clock->second)},
                       false};
}

/// 90..99 are 19xx, 0..89 are 20xx (KNX 3/7/2, DPT 11).
Result<Value> decode_date(const Dpt& type, ByteView bytes) {
  const int year = bytes[2] & 0x7f;
  const Clock clock{year + (year >= 90 ? 1900 : 2000), bytes[1] & 0x0f, bytes[0] & 0x1f, 0, 0, 0};
  if (year > 99 || !has_date(clock)) return no_time(type, bytes);
  return Value(fmt::format("{:04}-{:02}-{:02}", clock.year, clock.month, clock.day));
}

Result<wire::Payload> encode_date(const Dpt& type, const std::string& text) {
  const auto clock = parse_date(text);
  if (!clock) return wrong_kind(type, text, "a date as in 2026-11-20");
  if (clock->year < 1990 || clock->year > 2089) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} is out of range, expected 1990 to 2089", name_of(type), text));
  }
  return wire::Payload{{static_cast<std::uint8_t>(clock->day), static_cast<std::uint8_t>(clock->month),
                        static_cast<std::uint8_t>(clock->year % 100)},
                       false};
}

}  // namespace

Result<Value> decode_time(const Dpt& type, ByteView bytes) {
  if (type.form == Form::kTime) return decode_time_of_day(type, bytes);
  return type.form == Form::kDate ? decode_date(type, bytes) : decode_clock(type, bytes);
}

Result<wire::Payload> encode_time(const Dpt& type, const Value& value) {
  if (type.form == Form::kDateTime) return encode_clock(type, value);
  const auto* text = std::get_if<std::string>(&value);
  const bool time = type.form == Form::kTime;
  if (!text) return wrong_kind(type, value, time ? "a time as in 13:30:15" : "a date as in 2026-11-20");
  return time ? encode_time_of_day(type, *text) : encode_date(type, *text);
}

}  // namespace rubicon::networks::knx::dpt
