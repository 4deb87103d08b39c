#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/bytes.h"
#include "base/text.h"
#include "model/json_text.h"
#include "model/point.h"
#include "model/type_catalogue.h"
#include "rubicon/key.hpp"

namespace rubicon::model {

namespace {

constexpr std::size_t kMaxValueText = 65536;

tl::unexpected<Error> refuse(ErrorCode code, const Type& type, std::string_view text, std::string_view expected) {
  return fail(code, fmt::format("{}: {} is not {}", type.name, model::quoted(text), expected));
}

std::string range_text(const Type& type) {
  if (std::isinf(type.minimum) && std::isinf(type.maximum)) return "any number";
  if (std::isinf(type.maximum)) return fmt::format("a number from {}", type.minimum);
  if (std::isinf(type.minimum)) return fmt::format("a number up to {}", type.maximum);
  return fmt::format("a number from {} to {}", type.minimum, type.maximum);
}

Result<void> check_range(const Type& type, double number, std::string_view text) {
  if (number >= type.minimum && number <= type.maximum) return {};
  const auto unit = type.unit == "1" ? std::string() : fmt::format(" {}", type.unit);
  return refuse(ErrorCode::kOutOfRange, type, text, range_text(type) + unit);
}

/// The place of a word in a comma separated list.
std::optional<std::int64_t> word_index(std::string_view words, std::string_view word) {
  for (std::int64_t index = 0; !words.empty(); ++index) {
    const auto comma = words.find(',');
    if (words.substr(0, comma) == word) return index;
    if (comma == words.npos) break;
    words.remove_prefix(comma + 1);
  }
  return std::nullopt;
}

std::optional<std::string_view> word_at(std::string_view words, std::int64_t index) {
  for (; index >= 0 && !words.empty(); --index) {
    const auto comma = words.find(',');
    if (index == 0) return words.substr(0, comma);
    if (comma == words.npos) break;
    words.remove_prefix(comma + 1);
  }
  return std::nullopt;
}

/// The word that is the same but for case, blanks and hyphens, as parse_words() takes it.
std::optional<std::string_view> alike_word(std::string_view words, std::string_view text) {
  const auto wanted = plain_word(text);
  for (std::int64_t index = 0; !wanted.empty(); ++index) {
    const auto word = word_at(words, index);
    if (!word || plain_word(*word) == wanted) return word;
  }
  return std::nullopt;
}

template <class Number>
std::optional<Number> number_in(std::string_view text) {
  if (text.starts_with('+') && text.size() > 1 && text[1] != '-') text.remove_prefix(1);
  return base::parse_number<Number>(text);
}

Result<Value> parse_boolean(const Type& type, std::string_view text) {
  const auto alike = alike_word(type.words, text);
  if (const auto index = alike ? word_index(type.words, *alike) : std::nullopt; index && *index < 2)
    return Value(*index == 1);
  if (same_word(text, "on") || same_word(text, "true") || text == "1") return Value(true);
  if (same_word(text, "off") || same_word(text, "false") || text == "0") return Value(false);
  return refuse(ErrorCode::kInvalid, type, text,
                type.words.empty() ? "one of off, on" : fmt::format("one of {} (or off, on)", type.words));
}

/// The words are the point's: what is not a number may be one of them.
Result<Value> parse_own_word(const Type& type, std::string_view text, std::optional<std::int64_t> number) {
  if (text.empty() || text.size() > kMaxValueText) return refuse(ErrorCode::kInvalid, type, text, "a word or a number");
  if (!number) return Value(std::string(text));
  if (auto fits = check_range(type, static_cast<double>(*number), text); !fits) return fail(fits.error());
  return Value(*number);
}

Result<Value> parse_enumeration(const Type& type, std::string_view text) {
  if (word_index(type.words, text)) return Value(std::string(text));
  const auto number = number_in<std::int64_t>(text);
  const auto word = number ? word_at(type.words, *number) : std::nullopt;
  if (word) return Value(std::string(*word));
  if (const auto alike = alike_word(type.words, text)) return Value(std::string(*alike));
  if (type.words.empty()) return parse_own_word(type, text, number);
  return refuse(ErrorCode::kInvalid, type, text, fmt::format("one of {}", type.words));
}

Result<Value> parse_integer(const Type& type, std::string_view text) {
  const auto number = number_in<std::int64_t>(text);
  if (!number) return refuse(ErrorCode::kInvalid, type, text, "a whole number");
  if (auto fits = check_range(type, static_cast<double>(*number), text); !fits) return fail(fits.error());
  return Value(*number);
}

Result<Value> parse_real(const Type& type, std::string_view text) {
  const auto number = number_in<double>(text);
  if (!number || !std::isfinite(*number)) return refuse(ErrorCode::kInvalid, type, text, "a decimal number");
  if (auto fits = check_range(type, *number, text); !fits) return fail(fits.error());
  return Value(*number);
}

Result<Value> parse_json(const Type& type, std::string_view text) {
  if (text.size() > kMaxValueText) return refuse(ErrorCode::kOutOfRange, type, text, "at most 65536 bytes long");
  if (!is_json(text)) return refuse(ErrorCode::kInvalid, type, text, "JSON");
  return Value(Json{std::string(text)});
}

Result<void> check_number(const Type& type, const Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    const auto number = static_cast<double>(*whole);
    if (number >= type.minimum && number <= type.maximum) [[likely]]
      return {};
    return check_range(type, number, to_text(value));
  }
  const auto* real = std::get_if<double>(&value);
  if (!real || !std::isfinite(*real)) return refuse(ErrorCode::kInvalid, type, to_text(value), "a number");
  if (*real >= type.minimum && *real <= type.maximum) [[likely]]
    return {};
  return check_range(type, *real, to_text(value));
}

}  // namespace

Result<Value> TypeCatalogue::parse(const Type& type, std::string_view text) {
  switch (type.data) {
    case DataType::kBoolean: return parse_boolean(type, text);
    case DataType::kInteger: return parse_integer(type, text);
    case DataType::kReal: return parse_real(type, text);
    case DataType::kEnumeration: return parse_enumeration(type, text);
    case DataType::kJson: return parse_json(type, text);
    case DataType::kText:
      if (text.size() > kMaxValueText) return refuse(ErrorCode::kOutOfRange, type, text, "at most 65536 bytes long");
      return Value(std::string(text));
    case DataType::kBytes:
      if (text.size() > kMaxValueText) return refuse(ErrorCode::kOutOfRange, type, text, "at most 65536 bytes long");
      if (!base::from_hex(text)) return refuse(ErrorCode::kInvalid, type, text, "bytes in hex");
      return Value(std::string(text));
  }
  return refuse(ErrorCode::kUnsupported, type, text, "of a known data type");
}

Result<Value> TypeCatalogue::parse_reading(const Type& type, std::string_view text) {
  auto value = parse(type, text);
  if (value || type.data != DataType::kEnumeration) return value;
  return parse_own_word(type, text, number_in<std::int64_t>(text));
}

bool TypeCatalogue::names(const Type& type, std::string_view word) {
  return word_index(type.words, word).has_value();
}

Result<void> TypeCatalogue::check(const Type& type, const Value& value) {
  switch (type.data) {
    case DataType::kReal: return check_number(type, value);
    case DataType::kInteger:
      if (!std::holds_alternative<std::int64_t>(value)) {
        return refuse(ErrorCode::kInvalid, type, to_text(value), "a whole number");
      }
      return check_number(type, value);
    case DataType::kBoolean:
      if (std::holds_alternative<bool>(value)) return {};
      return refuse(ErrorCode::kInvalid, type, to_text(value), "off or on");
    case DataType::kEnumeration:
      if (const auto* word = std::get_if<std::string>(&value)) {
        if (!word->empty() && word->size() <= kMaxValueText) return {};
        return refuse(ErrorCode::kInvalid, type, *word, "a word or a number");
      }
      return check_number(type, value);
    case DataType::kJson:
      if (std::holds_alternative<Json>(value)) return {};
      return refuse(ErrorCode::kInvalid, type, to_text(value), "JSON");
    case DataType::kText:
    case DataType::kBytes:
      if (std::holds_alternative<std::string>(value)) return {};
      return refuse(ErrorCode::kInvalid, type, to_text(value), "text");
  }
  return {};
}

}  // namespace rubicon::model
