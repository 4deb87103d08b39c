#include "proxy/command.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "model/key.h"
#include "proxy/tuple_text.h"

namespace rubicon::proxy {

namespace {

constexpr std::size_t kLongestText = 4096;

std::optional<double> as_number(const Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
  if (const auto* real = std::get_if<double>(&value)) return *real;
  return std::nullopt;
}

template <class Number>
std::optional<Number> whole_text(std::string_view text) {
  Number number{};
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

/// For a type the catalogue does not know: a number if it reads as one, else the text itself.
Value untyped(std::string_view text) {
  if (const auto whole = whole_text<std::int64_t>(text)) return *whole;
  if (const auto real = whole_text<double>(text); real && std::isfinite(*real)) return *real;
  return std::string(text);
}

Result<Value> in_range(const Point& point, std::string_view text, Value value) {
  const auto& own = *point.details->capability;
  const auto number = as_number(value);
  if (!number) return value;
  if (own.minimum && *number < *own.minimum) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} is below the minimum {:g}", point.details->id, model::quoted(text), *own.minimum));
  }
  if (own.maximum && *number > *own.maximum) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} is above the maximum {:g}", point.details->id, model::quoted(text), *own.maximum));
  }
  return value;
}

}  // namespace

std::string_view to_string(CommandState state) {
  switch (state) {
    case CommandState::kQueued: return "queued";
    case CommandState::kSent: return "sent";
    case CommandState::kConfirmed: return "confirmed";
    case CommandState::kAssumed: return "assumed";
    case CommandState::kRefused: return "refused";
    case CommandState::kFailed: return "failed";
    case CommandState::kTimedOut: return "timed-out";
    case CommandState::kExpired: return "expired";
    case CommandState::kSuperseded: return "superseded";
  }
  return "queued";
}

std::string command_text(const Command& command) {
  std::string out = fmt::format("{{\"state\":\"{}\",\"creator\":{},\"request\":{},\"value\":", to_string(command.state),
                                number(command.creator), command.creator_request);
  append_json(command.text, out);
  out += ",\"since\":";
  append_seconds(command.since, out);
  out += ",\"reason\":";
  append_json(command.reason, out);
  return out + '}';
}

Result<Value> parse_command(const Point& point, std::string_view text) {
  if (text.size() > kLongestText) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: a command may have {} bytes, this one has {}",
                                                    point.details->id, kLongestText, text.size()));
  }
  if (!point.type) return in_range(point, text, untyped(text));
  auto value = TypeCatalogue::parse(*point.type, text);
  if (!value) return fail(value.error());
  return in_range(point, text, std::move(*value));
}

bool confirms(const Value& reported, const Value& commanded) {
  const auto is = as_number(reported);
  const auto wanted = as_number(commanded);
  if (!is || !wanted) return to_text(reported) == to_text(commanded);
  const bool whole = std::holds_alternative<std::int64_t>(commanded) && std::holds_alternative<std::int64_t>(reported);
  return whole ? reported == commanded : std::abs(*is - *wanted) <= std::abs(*wanted) * 1e-3;
}

}  // namespace rubicon::proxy
