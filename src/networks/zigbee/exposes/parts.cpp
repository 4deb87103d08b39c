#include "networks/zigbee/exposes/parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/nearest.h"
#include "base/text.h"
#include "model/json_text.h"
#include "model/words.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee::exposes {

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
  constexpr std::size_t kMostNamed = 20;
  std::vector<std::string> names;
  std::string list = "one of";
  for (const auto& word : words) {
    if (names.size() < kMostNamed) list += (names.empty() ? " " : ", ") + word.name;
    names.push_back(word.name);
  }
  return list + (names.size() > kMostNamed ? ", ..." : "") + suggestion(text_of(value), names);
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

}  // namespace rubicon::networks::zigbee::exposes
