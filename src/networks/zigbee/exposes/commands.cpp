#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_depth.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "model/units.h"
#include "model/words.h"
#include "networks/zigbee/exposes/mapping.h"
#include "networks/zigbee/exposes/parts.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee::exposes {

namespace {

using Coding = MappedPoint::Coding;
using Form = MappedPoint::Coding::Form;

constexpr double kGrain = 1e-6;  ///< of a step: what rounding may leave

tl::unexpected<Error> refused(ErrorCode code, const MappedPoint& point, const Value& value, std::string_view expected) {
  return fail(code,
              fmt::format("{}: {} is not {}", point.capability.type_name, model::quoted(to_text(value)), expected));
}

std::optional<double> number_in(const Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
  if (const auto* real = std::get_if<double>(&value); real && std::isfinite(*real)) return *real;
  return std::nullopt;
}

/// The JSON number of a value: the inverse of decode().
double in_json(const Coding& coding, double value) {
  if (coding.multiply == coding.divide && coding.shift == 0) return value;
  const model::UnitConversion back{coding.divide, coding.multiply, 0};
  return back(value) - coding.shift + 0.0;
}

double on_grid(double number, double origin, double step) {
  return origin + std::round((number - origin) / step) * step;
}

/// Steps count from zero or from the minimum, whichever is nearer.
double nearest_step(const Coding& coding, double number) {
  const double from_zero = on_grid(number, 0, coding.step);
  const double from_minimum = on_grid(number, coding.minimum.value_or(0), coding.step);
  return std::abs(from_minimum - number) < std::abs(from_zero - number) ? from_minimum : from_zero;
}

/// 12 digits, as conversions have: 0.1 * 3 is 0.3.
double without_noise(double number) {
  return base::parse_number<double>(fmt::format("{:.12g}", number)).value_or(number);
}

std::string json_number(double number) {
  constexpr double kExact = 9007199254740992.0;
  if (number == std::floor(number) && std::abs(number) <= kExact) return fmt::format("{}", std::int64_t(number));
  return fmt::format("{}", number);
}

bool is_preset(const Coding& coding, double number) {
  return std::any_of(coding.words.begin(), coding.words.end(),
                     [number](const NamedValue& preset) { return base::parse_number<double>(preset.json) == number; });
}

std::string bound_text(const Coding& coding, double number) {
  return fmt::format("{}", model::UnitConversion{coding.multiply, coding.divide, coding.shift}(number) + 0.0);
}

/// The bounds in the unit of the type.
std::string bounds_text(const MappedPoint& point) {
  const auto& coding = point.coding;
  const auto unit = point.capability.unit.empty() ? std::string() : " " + point.capability.unit;
  auto low = coding.minimum, high = coding.maximum;
  if (coding.multiply < 0) std::swap(low, high);
  if (!high) return fmt::format("a number from {}{}", bound_text(coding, low.value_or(0)), unit);
  if (!low) return fmt::format("a number up to {}{}", bound_text(coding, *high), unit);
  return fmt::format("a number from {} to {}{}", bound_text(coding, *low), bound_text(coding, *high), unit);
}

std::string step_text(const Coding& coding) {
  return fmt::format("{}", model::UnitConversion{coding.multiply, coding.divide, 0}(coding.step));
}

bool is_outside(const Coding& coding, double number) {
  return (coding.minimum && number < *coding.minimum) || (coding.maximum && number > *coding.maximum);
}

/// Where the leaf has steps: the one that is meant.
Result<double> on_step(const MappedPoint& point, const Value& value, double number) {
  const auto& coding = point.coding;
  if (coding.step <= 0) return number;
  const auto step = nearest_step(coding, number);
  if (!coding.rounded && std::abs(step - number) > coding.step * kGrain)
    return refused(ErrorCode::kOutOfRange, point, value, fmt::format("in steps of {}", step_text(coding)));
  return without_noise(step);
}

Result<std::string> encode_number(const MappedPoint& point, const Value& value) {
  const auto& coding = point.coding;
  if (const auto* text = std::get_if<std::string>(&value)) {
    for (const auto& preset : coding.words) {
      if (preset.json.starts_with('"') && preset.json == model::dump(nlohmann::json(*text))) return preset.json;
    }
  }
  const auto given = number_in(value);
  if (!given) return refused(ErrorCode::kInvalid, point, value, "a number");
  const auto exact = in_json(coding, *given);
  if (is_preset(coding, exact)) return json_number(exact);
  if (coding.form == Form::kInteger && *given != std::floor(*given))
    return refused(ErrorCode::kInvalid, point, value, "a whole number");
  const auto number = on_step(point, value, exact);
  if (!number) return fail(number.error());
  if (is_outside(coding, *number)) return refused(ErrorCode::kOutOfRange, point, value, bounds_text(point));
  if (!std::isfinite(*number)) return refused(ErrorCode::kOutOfRange, point, value, "a number that JSON can hold");
  return json_number(*number);
}

Result<std::string> encode_binary(const MappedPoint& point, const Value& value) {
  const auto& words = point.coding.words;
  if (const auto* on = std::get_if<bool>(&value)) return words[*on ? 1 : 0].json;
  const auto text = to_text(value);
  for (const auto& word : words) {
    if (!text.empty() && word.name == text) return word.json;
  }
  return refused(ErrorCode::kInvalid, point, value, "on or off");
}

std::string word_list(const std::vector<NamedValue>& words) {
  constexpr std::size_t kMostNamed = 20;
  std::string list = "one of";
  for (std::size_t i = 0; i < words.size() && i < kMostNamed; ++i) list += (i == 0 ? " " : ", ") + words[i].name;
  return words.size() > kMostNamed ? list + ", ..." : list;
}

Result<std::string> encode_word(const MappedPoint& point, const Value& value) {
  const auto& words = point.coding.words;
  const auto text = to_text(value);
  for (const auto& word : words) {
    if (word.name == text) return word.json;
  }
  const auto alike = std::find_if(words.begin(), words.end(), [&](const NamedValue& word) {
    return !text.empty() && model::plain_word(word.name) == model::plain_word(text);
  });
  if (alike != words.end()) return alike->json;
  return refused(ErrorCode::kInvalid, point, value, word_list(words));
}

Result<std::string> encode_text(const MappedPoint& point, const Value& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr) return refused(ErrorCode::kInvalid, point, value, "a text");
  std::string json;
  model::append_json(*text, json);
  return json;
}

Result<std::string> encode_json(const MappedPoint& point, const Value& value, char first, std::string_view expected) {
  const auto* json = std::get_if<Json>(&value);
  const auto text = base::trimmed(json == nullptr ? std::string_view() : std::string_view(json->text));
  if (!text.starts_with(first) || !model::is_json(text)) return refused(ErrorCode::kInvalid, point, value, expected);
  const auto& parts = point.coding.parts;
  if (parts.empty()) return std::string(text);
  if (base::is_nested_deeper(text, kDeepestJson))
    return refused(ErrorCode::kInvalid, point, value, fmt::format("JSON with at most {} levels", kDeepestJson));
  auto tree = model::parse_json(text);
  const auto& where = point.capability.type_name;
  const auto right = tree.is_array() ? check_items(parts, where, tree) : check_members(parts, where, tree);
  if (!right) return fail(right.error());
  return model::dump(tree);
}

Result<std::string> encode_colour(const MappedPoint& point, const Value& value, const char* first, const char* second,
                                  double most, double other_most) {
  const auto* json = std::get_if<Json>(&value);
  const auto tree = model::object_of(json == nullptr ? std::string_view() : std::string_view(json->text));
  const auto one = tree.find(first), other = tree.find(second);
  const auto fits = [](const auto& number, double maximum) {
    return number->is_number() && number->template get<double>() >= 0 && number->template get<double>() <= maximum;
  };
  if (one == tree.end() || other == tree.end() || !fits(one, most) || !fits(other, other_most)) {
    return refused(ErrorCode::kInvalid, point, value,
                   fmt::format("an object with {} from 0 to {} and {} from 0 to {}", first, most, second, other_most));
  }
  return fmt::format("{{\"{}\":{},\"{}\":{}}}", first, model::dump(*one), second, model::dump(*other));
}

}  // namespace

Result<std::string> encode(const MappedPoint& point, const Value& value) {
  if (!point.access.settable) {
    return fail(ErrorCode::kRefused, fmt::format("{} of the device cannot be set", point.capability.type_name));
  }
  switch (point.coding.form) {
    case Form::kNumber:
    case Form::kInteger: return encode_number(point, value);
    case Form::kBinary: return encode_binary(point, value);
    case Form::kWords: return encode_word(point, value);
    case Form::kText: return encode_text(point, value);
    case Form::kObject: return encode_json(point, value, '{', "a JSON object");
    case Form::kList: return encode_json(point, value, '[', "a JSON list");
    case Form::kColourXy: return encode_colour(point, value, "x", "y", 1, 1);
    case Form::kColourHueSaturation: return encode_colour(point, value, "hue", "saturation", 360, 100);
  }
  return refused(ErrorCode::kUnsupported, point, value, "of a known form");
}

}  // namespace rubicon::networks::zigbee::exposes
