#include "networks/zigbee/device/state_message.h"

#include <fmt/format.h>
#include <simdjson.h>

#include <cstring>
#include <vector>

#include "base/text.h"

namespace rubicon::networks::zigbee::device {

namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::minutes;

/// The end of the year 2199: ages in nanoseconds reach no further than 292 years.
constexpr WallTime kMaxTime{milliseconds(7'258'118'399'999)};

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
    if (*epoch <= 0 || *epoch > kMaxTime.time_since_epoch() / milliseconds(1)) return std::nullopt;
    return WallTime(milliseconds(*epoch));
  }
  if (json.size() < 2 || !take(json, '"') || json.back() != '"') return std::nullopt;
  json.remove_suffix(1);
  const auto date = take_date(json);
  const auto clock = date ? take_clock(json) : std::nullopt;
  const auto offset = clock ? take_offset(json) : std::nullopt;
  if (!offset || !json.empty()) return std::nullopt;
  const auto time = *date + *clock - *offset;
  return time <= kMaxTime ? std::optional(time) : std::nullopt;
}

namespace {

namespace ondemand = simdjson::ondemand;

simdjson::error_code take_json(ondemand::value value, std::string_view& json) {
  ondemand::json_type type{};
  if (const auto error = value.type().get(type)) return error;
  switch (type) {
    case ondemand::json_type::object: {
      ondemand::object object;
      if (const auto error = value.get_object().get(object)) return error;
      return object.raw_json().get(json);
    }
    case ondemand::json_type::array: {
      ondemand::array array;
      if (const auto error = value.get_array().get(array)) return error;
      return array.raw_json().get(json);
    }
    default: json = value.raw_json_token(); return simdjson::SUCCESS;
  }
}

}  // namespace

struct StateReader::Impl {
  simdjson::error_code read(std::string_view payload) {
    const auto needed = payload.size() + simdjson::SIMDJSON_PADDING;
    if (buffer.size() < needed) buffer.resize(needed);
    std::memcpy(buffer.data(), payload.data(), payload.size());
    ondemand::document document;
    if (const auto error = parser.iterate(buffer.data(), payload.size(), buffer.size()).get(document)) return error;
    ondemand::object object;
    if (const auto error = document.get_object().get(object)) return error;
    for (auto field : object) {
      Member member;
      if (const auto error = field.unescaped_key().get(member.key)) return error;
      ondemand::value value;
      if (const auto error = field.value().get(value)) return error;
      if (const auto error = take_json(value, member.json)) return error;
      member.json = base::trimmed(member.json);
      if (members.size() == kMaxMembers) return simdjson::CAPACITY;
      members.push_back(member);
    }
    const bool at_end = document.current_location().error() == simdjson::OUT_OF_BOUNDS;
    return at_end ? simdjson::SUCCESS : simdjson::TRAILING_CONTENT;
  }

  ondemand::parser parser;
  std::vector<char> buffer;
  std::vector<Member> members;
};

StateReader::StateReader() : impl_(std::make_unique<Impl>()) {}
StateReader::~StateReader() = default;

Result<std::span<const Member>> StateReader::read(std::string_view payload) {
  impl_->members.clear();
  if (payload.size() > kMaxPayload) {
    return fail(ErrorCode::kOutOfRange, fmt::format("state: {} bytes, more than {}", payload.size(), kMaxPayload));
  }
  const auto error = impl_->read(payload);
  if (error == simdjson::CAPACITY)
    return fail(ErrorCode::kOutOfRange, fmt::format("state: more than {} members", kMaxMembers));
  if (error) return fail(ErrorCode::kInvalid, fmt::format("state: no JSON object: {}", simdjson::error_message(error)));
  return std::span<const Member>(impl_->members);
}

}  // namespace rubicon::networks::zigbee::device
