#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "model/units.h"
#include "networks/zigbee/exposes/mapping.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee::exposes {

namespace {

using Coding = MappedPoint::Coding;
using Form = MappedPoint::Coding::Form;

tl::unexpected<Error> unreadable(const MappedPoint& point, std::string_view json, std::string_view expected) {
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: {} is not {}", point.capability.type_name, model::quoted(json), expected));
}

bool is_string(std::string_view json) {
  return json.size() >= 2 && json.front() == '"' && json.back() == '"';
}

bool is_plain(char c) {
  return c >= 0x20 && c < 0x7f && c != '\\' && c != '"';
}

/// The text of a JSON string; nullopt if it is broken.
std::optional<std::string> unquoted(std::string_view json) {
  const auto inner = json.substr(1, json.size() - 2);
  if (std::all_of(inner.begin(), inner.end(), is_plain)) return std::string(inner);
  const auto tree = model::parse_json(json);
  return tree.is_string() ? std::optional(tree.get<std::string>()) : std::nullopt;
}

/// The text of a string; a number or boolean as it is spelled. nullopt for all else.
std::optional<std::string> scalar_text(std::string_view json) {
  if (is_string(json)) return unquoted(json);
  const bool number = !json.empty() && (json[0] == '-' || (json[0] >= '0' && json[0] <= '9'));
  const bool scalar = json == "true" || json == "false" || (number && model::is_json(json));
  return scalar ? std::optional(std::string(json)) : std::nullopt;
}

double in_type(const Coding& coding, double number) {
  if (coding.multiply == coding.divide && coding.shift == 0) return number;
  return model::UnitConversion{coding.multiply, coding.divide, coding.shift}(number) + 0.0;  // no -0
}

/// A share of a range (brightness) with the fewest digits that mean the same step: 55, not 55.1181102362.
double rounded_in_type(const Coding& coding, double number) {
  const auto exact = in_type(coding, number);
  const bool is_step = coding.rounded && coding.step > 0 && std::remainder(number, coding.step) == 0;
  if (!is_step || coding.multiply == coding.divide) return exact;
  const model::UnitConversion back{coding.divide, coding.multiply, 0};
  for (const double scale : {1.0, 10.0, 100.0}) {
    const auto value = std::round(exact * scale) / scale;
    if (std::abs(back(value) - coding.shift - number) < coding.step / 2) return value;
  }
  return exact;
}

/// Some devices write numbers as strings.
std::optional<double> number_of_json(std::string_view json) {
  if (is_string(json)) json = json.substr(1, json.size() - 2);
  if (json.empty() || (json[0] != '-' && (json[0] < '0' || json[0] > '9'))) return std::nullopt;
  const auto number = base::parse_number<double>(json);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

Result<Value> decode_number(const MappedPoint& point, std::string_view json) {
  const auto number = number_of_json(json);
  if (number) {
    const auto value = rounded_in_type(point.coding, *number);
    return std::isfinite(value) ? Result<Value>(Value(value)) : unreadable(point, json, "a finite number in its unit");
  }
  for (const auto& preset : point.coding.words) {
    if (preset.json == json && !point.capability.data && is_string(json)) {
      if (auto text = unquoted(json)) return Value(std::move(*text));
    }
  }
  return unreadable(point, json, "a number");
}

Result<Value> decode_integer(const MappedPoint& point, std::string_view json) {
  const auto number = number_of_json(json);
  if (!number) return unreadable(point, json, "a number");
  const auto value = in_type(point.coding, *number);
  constexpr double kMaxExact = 9007199254740992.0;  // 2^53: beyond it a double is not exact
  if (!std::isfinite(value) || value != std::floor(value) || std::abs(value) > kMaxExact)
    return unreadable(point, json, "a whole number");
  return Value(static_cast<std::int64_t>(value));
}

Result<Value> decode_binary(const MappedPoint& point, std::string_view json) {
  const auto& words = point.coding.words;
  if (json == words[1].json) return Value(true);
  if (json == words[0].json) return Value(false);
  return unreadable(point, json, fmt::format("one of {}, {}", words[0].json, words[1].json));
}

/// A word that the leaf does not declare stands for itself.
Result<Value> decode_words(const MappedPoint& point, std::string_view json) {
  for (const auto& word : point.coding.words) {
    if (word.json == json) return Value(word.name);
  }
  auto text = scalar_text(json);
  const auto respelled = text ? model::dump(nlohmann::json(*text)) : std::string();
  for (const auto& word : point.coding.words) {
    if (word.json == respelled) return Value(word.name);
  }
  if (text && !text->empty()) return Value(std::move(*text));
  return unreadable(point, json, "a word");
}

Result<Value> decode_text(const MappedPoint& point, std::string_view json) {
  auto text = scalar_text(json);
  return text ? Result<Value>(Value(std::move(*text))) : unreadable(point, json, "a text");
}

Result<Value> decode_json(const MappedPoint& point, std::string_view json) {
  if (base::is_nested_deeper(json, kDeepestJson))
    return unreadable(point, json, fmt::format("JSON with at most {} levels", kDeepestJson));
  if (!model::is_json(json)) return unreadable(point, json, "valid JSON");
  return Value(Json{std::string(json)});
}

/// The two numbers of a colour; a colour may have more members. Without them it is unknown.
Result<Value> decode_colour(const MappedPoint& point, std::string_view json, const char* first, const char* second) {
  const auto tree = base::is_nested_deeper(json, kDeepestJson) ? nlohmann::json() : model::parse_json(json);
  if (!tree.is_object()) return unreadable(point, json, "an object of numbers");
  const auto one = tree.find(first), other = tree.find(second);
  if (one == tree.end() || other == tree.end() || !one->is_number() || !other->is_number()) return Value();
  return Value(Json{fmt::format("{{\"{}\":{},\"{}\":{}}}", first, model::dump(*one), second, model::dump(*other))});
}

}  // namespace

Result<Value> decode(const MappedPoint& point, std::string_view json) {
  json = base::trimmed(json);
  if (json == "null") return Value();
  switch (point.coding.form) {
    case Form::kNumber: return decode_number(point, json);
    case Form::kInteger: return decode_integer(point, json);
    case Form::kBinary: return decode_binary(point, json);
    case Form::kWords: return decode_words(point, json);
    case Form::kText: return decode_text(point, json);
    case Form::kObject:
    case Form::kList: return decode_json(point, json);
    case Form::kColourXy: return decode_colour(point, json, "x", "y");
    case Form::kColourHueSaturation: return decode_colour(point, json, "hue", "saturation");
  }
  return unreadable(point, json, "readable");
}

}  // namespace rubicon::networks::zigbee::exposes
