#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/compare_text.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "model/point.h"
#include "model/units.h"
#include "networks/zigbee/exposes/leaf.h"
#include "networks/zigbee/exposes/mapping.h"
#include "rubicon/key.hpp"
#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::exposes {

// The value of a composite or list in a set message, before it is sent: Zigbee2MQTT does not answer one that it
// rejects. `where` names the value in errors: `warning.mode`. Parts that are null are left to Zigbee2MQTT.

/// Checks the members of an object against the features of a composite, and respells words as the definition has them.
/// kInvalid for a member that no feature has and for a word that the feature has not, kOutOfRange for a number beyond
/// its bounds. A composite without features takes everything.
Result<void> check_members(const std::vector<Leaf>& features, const std::string& where, nlohmann::json& object);
/// The same for the items of a list; `item` has one leaf, or none for a list of anything.
Result<void> check_items(const std::vector<Leaf>& item, const std::string& where, nlohmann::json& list);

namespace {

using Tree = nlohmann::json;

std::string text_of(const Tree& value) {
  return value.is_string() ? value.get<std::string>() : model::dump(value);
}

tl::unexpected<Error> refused(ErrorCode code, const std::string& where, const Tree& value, std::string_view expected) {
  return fail(code, fmt::format("{} is {}, expected {}", where, model::quoted(text_of(value)), expected));
}

std::string suggestion(std::string_view word, const std::vector<std::string>& words) {
  const auto text = base::did_you_mean(word, words);
  return text.empty() ? text : "; " + text;
}

/// The word that the value means: as it is spelled, else the only one that is the same but for case and blanks.
const NamedValue* find_word(const std::vector<NamedValue>& words, const Tree& value) {
  const auto json = model::dump(value);
  const auto exact =
      std::find_if(words.begin(), words.end(), [&](const NamedValue& word) { return word.json == json; });
  if (exact != words.end()) return &*exact;
  const auto plain = model::plain_word(text_of(value));
  const auto alike = std::find_if(words.begin(), words.end(), [&](const NamedValue& word) {
    return !plain.empty() && model::plain_word(word.name) == plain;
  });
  return alike == words.end() ? nullptr : &*alike;
}

std::string word_list(const std::vector<NamedValue>& words, const Tree& value) {
  constexpr std::size_t kMaxNamedEntries = 20;
  std::vector<std::string> names;
  std::string list = "one of";
  for (const auto& word : words) {
    if (names.size() < kMaxNamedEntries) list += (names.empty() ? " " : ", ") + word.name;
    names.push_back(word.name);
  }
  return list + (names.size() > kMaxNamedEntries ? ", ..." : "") + suggestion(text_of(value), names);
}

Result<void> check_word(const std::vector<NamedValue>& words, const std::string& where, Tree& value) {
  if (words.empty()) return {};
  const auto* word = find_word(words, value);
  if (word == nullptr) return refused(ErrorCode::kInvalid, where, value, word_list(words, value));
  value = model::parse_json(word->json);
  return {};
}

std::string bounds_text(const Leaf& leaf) {
  const auto unit = leaf.unit.empty() ? std::string() : " " + leaf.unit;
  if (leaf.minimum && leaf.maximum) return fmt::format("a number from {} to {}{}", *leaf.minimum, *leaf.maximum, unit);
  if (leaf.minimum) return fmt::format("a number from {}{}", *leaf.minimum, unit);
  if (leaf.maximum) return fmt::format("a number up to {}{}", *leaf.maximum, unit);
  return "a number" + (unit.empty() ? unit : " of" + unit);
}

/// Presets may lie beyond the bounds; codes may be written as texts, because they begin with zeros.
Result<void> check_number(const Leaf& leaf, const std::string& where, const Tree& value) {
  if (find_word(leaf.values, value) != nullptr) return {};
  const auto number = value.is_number()   ? std::optional(value.get<double>())
                      : value.is_string() ? base::parse_number<double>(value.get<std::string>())
                                          : std::nullopt;
  if (!number) return refused(ErrorCode::kInvalid, where, value, bounds_text(leaf));
  if ((leaf.minimum && *number < *leaf.minimum) || (leaf.maximum && *number > *leaf.maximum))
    return refused(ErrorCode::kOutOfRange, where, value, bounds_text(leaf));
  return {};
}

/// Whether the device itself has this value: a feature may call `false` on.
bool is_spelled(const Leaf& leaf, const Tree& value) {
  const auto json = model::dump(value);
  return json == leaf.on.json || json == leaf.off.json;
}

Result<void> check_part(const Leaf& leaf, const std::string& where, Tree& value) {
  if (value.is_null()) return {};
  switch (leaf.form) {
    case LeafForm::kNumeric: return check_number(leaf, where, value);
    case LeafForm::kBinary:
      if (value.is_boolean() && !is_spelled(leaf, value))
        value = model::parse_json(value.get<bool>() ? leaf.on.json : leaf.off.json);
      return check_word({leaf.on, leaf.off}, where, value);
    case LeafForm::kEnum: return check_word(leaf.values, where, value);
    case LeafForm::kText:
      if (value.is_string() || value.is_number()) return {};
      return refused(ErrorCode::kInvalid, where, value, "a text");
    case LeafForm::kList:
      if (!value.is_array()) return refused(ErrorCode::kInvalid, where, value, "a JSON list");
      return check_items(leaf.features, where, value);
    case LeafForm::kComposite:
      if (!value.is_object()) return refused(ErrorCode::kInvalid, where, value, "a JSON object");
      return check_members(leaf.features, where, value);
  }
  return {};
}

const std::string& key_of(const Leaf& feature) {
  return feature.property.empty() ? feature.name : feature.property;
}

/// By its key; by its name where the definition gives it another key in states.
const Leaf* find_feature(const std::vector<Leaf>& features, const std::string& member) {
  for (const auto& feature : features)
    if (key_of(feature) == member) return &feature;
  for (const auto& feature : features)
    if (feature.name == member) return &feature;
  return nullptr;
}

}  // namespace

Result<void> check_members(const std::vector<Leaf>& features, const std::string& where, Tree& object) {
  if (features.empty()) return {};
  std::vector<std::string> keys;
  for (const auto& feature : features) keys.push_back(key_of(feature));
  for (auto& [member, value] : object.items()) {
    const auto* feature = find_feature(features, member);
    if (feature == nullptr)
      return fail(ErrorCode::kInvalid, fmt::format("{} has no {}, expected {}{}", where, model::quoted(member),
                                                   fmt::join(keys, ", "), suggestion(member, keys)));
    if (auto right = check_part(*feature, where + "." + member, value); !right) return right;
  }
  return {};
}

Result<void> check_items(const std::vector<Leaf>& item, const std::string& where, Tree& list) {
  if (item.empty()) return {};
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (auto right = check_part(item.front(), fmt::format("{}[{}]", where, i), list[i]); !right) return right;
  }
  return {};
}

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
  constexpr std::size_t kMaxNamedEntries = 20;
  std::string list = "one of";
  for (std::size_t i = 0; i < words.size() && i < kMaxNamedEntries; ++i) list += (i == 0 ? " " : ", ") + words[i].name;
  return words.size() > kMaxNamedEntries ? list + ", ..." : list;
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
