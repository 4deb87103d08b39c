#include "proxy/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "model/words.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

namespace {

constexpr std::size_t kMaxCommand = 4096;

std::optional<double> as_number(const Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
  if (const auto* real = std::get_if<double>(&value)) return *real;
  return std::nullopt;
}

/// The value of a point without a type of the catalogue: a number if the text is one, else the text.
Value untyped(std::string_view text) {
  if (const auto whole = base::parse_number<std::int64_t>(text)) return *whole;
  if (const auto real = base::parse_number<double>(text); real && std::isfinite(*real)) return *real;
  return std::string(text);
}

/// The type with the bounds and the unit of the point, by which its commands are checked.
model::Type bounded(const Point& point) {
  const auto& own = *point.details->capability;
  model::Type type;
  type.name = point.details->id;
  type.unit = "1";
  if (point.type) type = *point.type;
  type.minimum = std::max(type.minimum, own.minimum.value_or(type.minimum));
  type.maximum = std::min(type.maximum, own.maximum.value_or(type.maximum));
  if (!own.unit.empty()) type.unit = own.unit;
  return type;
}

/// Checks numbers; other values have no range.
Result<Value> in_range(const model::Type& type, Value value) {
  if (!as_number(value)) return value;
  if (auto fits = TypeCatalogue::check(type, value); !fits) return fail(fits.error());
  return value;
}

/// A peer may declare words for a point of any type; they count only where there is a use for them.
bool has_own_words(const Point& point) {
  const auto data = point.type->data;
  const bool takes =
      data == model::DataType::kEnumeration || (data == model::DataType::kJson && point.type->words.empty());
  return takes && !point.details->capability->words.empty();
}

std::string words_text(const Point& point) {
  const auto& own = point.details->capability->words;
  std::string list;
  for (const auto& word : own.empty() ? model::words_in(point.type->words) : own)
    list += (list.empty() ? "" : ", ") + word.text;
  return list;
}

/// A number that has no word: only where the bounds of the point say which numbers there are.
Result<Value> number_without_word(const model::Type& type, const Point& point, std::int64_t number) {
  const auto& own = *point.details->capability;
  if (own.minimum && own.maximum) return in_range(type, Value(number));
  return fail(ErrorCode::kInvalid, fmt::format("{}: '{}' is not one of {}", type.name, number, words_text(point)));
}

Result<Value> parse_enumeration(const model::Type& type, const Point& point, std::string_view text) {
  auto value = has_own_words(point) ? model::parse_words(type, point.details->capability->words, text)
                                    : TypeCatalogue::parse(type, text);
  const auto* number = value ? std::get_if<std::int64_t>(&*value) : nullptr;
  const bool has_words = has_own_words(point) || !type.words.empty();
  if (number && has_words) return number_without_word(type, point, *number);
  const auto given = value || !has_words ? std::nullopt : base::parse_number<std::int64_t>(text);
  return given ? number_without_word(type, point, *given) : value;
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
  return model::command_status_to_json({std::string(to_string(command.state)),
                                        {command.creator, command.commander, command.creator_request},
                                        command.text,
                                        command.since,
                                        command.until,
                                        command.reason,
                                        command.by});
}

Result<Value> parse_command(const Point& point, std::string_view text) {
  if (text.size() > kMaxCommand) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: a command may have {} bytes, this one has {}",
                                                    point.details->id, kMaxCommand, text.size()));
  }
  const auto type = bounded(point);
  if (!point.type) return in_range(type, untyped(text));
  if (type.data == model::DataType::kEnumeration) return parse_enumeration(type, point, text);
  if (!has_own_words(point)) return TypeCatalogue::parse(type, text);
  auto value = model::parse_words(type, point.details->capability->words, text);
  return value ? in_range(type, std::move(*value)) : value;
}

bool confirms(const Value& reported, const Value& commanded) {
  const auto is = as_number(reported);
  const auto wanted = as_number(commanded);
  if (!is || !wanted) return to_text(reported) == to_text(commanded);
  const bool whole = std::holds_alternative<std::int64_t>(commanded) && std::holds_alternative<std::int64_t>(reported);
  return whole ? reported == commanded : std::abs(*is - *wanted) <= std::abs(*wanted) * 1e-3;
}

}  // namespace rubicon::proxy
