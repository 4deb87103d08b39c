#include "model/point.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "rubicon/key.hpp"

namespace rubicon::model {

namespace {

using Tree = nlohmann::ordered_json;
using Words = std::vector<Word>;

constexpr std::size_t kMaxInput = 4096;

char small(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

std::string list_of(const Words& words) {
  std::string list;
  for (const auto& word : words) list.append(list.empty() ? "" : ", ").append(word.text);
  return list;
}

tl::unexpected<Error> not_one_of(const Words& words, std::string_view text) {
  return fail(ErrorCode::kInvalid,
              fmt::format("{} is not one of {}, or a number", model::quoted(text), list_of(words)));
}

/// A peer may give its bits any number.
std::uint32_t bit(const Word& word) {
  return word.value < 32 ? 1U << word.value : 0;
}

std::uint32_t all_bits(const Words& words) {
  std::uint32_t bits = 0;
  for (const auto& word : words) bits |= bit(word);
  return bits;
}

Result<std::uint32_t> bit_named(const Words& words, std::string_view text) {
  const auto found = std::ranges::find_if(words, [&, wanted = plain_word(text)](const Word& word) {
    return same_word(word.text, text) || (!wanted.empty() && plain_word(word.text) == wanted);
  });
  if (found == words.end()) return not_one_of(words, text);
  return bit(*found);
}

Result<std::uint32_t> bits_in_number(const Words& words, const Tree& number) {
  if (!number.is_number_unsigned() || (number.get<std::uint64_t>() & ~std::uint64_t{all_bits(words)}) != 0) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{} has bits without a name, expected some of {:#x}",
                                                    model::quoted(dump(number)), all_bits(words)));
  }
  return number.get<std::uint32_t>();
}

Result<std::uint32_t> bits_in_list(const Words& words, const Tree& list) {
  std::uint32_t raw = 0;
  for (const auto& item : list) {
    if (!item.is_string()) return not_one_of(words, dump(item).substr(0, 40));
    const auto one = bit_named(words, item.get_ref<const std::string&>());
    if (!one) return one;
    raw |= *one;
  }
  return raw;
}

/// The number under "raw" first, then the named bits on top of it.
Result<std::uint32_t> bits_in_object(const Words& words, const Tree& object) {
  std::uint32_t raw = 0;
  if (const auto number = object.find("raw"); number != object.end()) {
    if (!number->is_number_integer()) return fail(ErrorCode::kInvalid, "raw: expected a number");
    const auto bits = bits_in_number(words, *number);
    if (!bits) return bits;
    raw = *bits;
  }
  for (const auto& item : object.items()) {
    if (item.key() == "raw") continue;
    const auto one = bit_named(words, item.key());
    if (!one) return one;
    if (!item.value().is_boolean())
      return fail(ErrorCode::kInvalid, fmt::format("{}: expected true or false", model::quoted(item.key())));
    raw = item.value().get<bool>() ? raw | *one : raw & ~*one;
  }
  return raw;
}

std::string_view word_of(const Words& words, std::uint32_t value) {
  const auto found = std::ranges::find(words, value, &Word::value);
  return found == words.end() ? std::string_view() : found->text;
}

/// 20.610 of KNX has one word for two numbers: what was given counts.
Result<Value> enumeration_value(const Words& words, std::string_view text) {
  const auto value = value_of_word(words, text);
  if (!value) return not_one_of(words, text);
  const auto word = word_of(words, *value);
  return word.empty() ? Value(std::int64_t{*value}) : Value(std::string(word));
}

Result<Value> set_value(const Words& words, std::string_view text) {
  const auto bits = bits_of(words, text);
  if (!bits) return fail(bits.error());
  return Value(set_of(words, *bits));
}

}  // namespace

Words words_in(std::string_view words) {
  Words list;
  while (!words.empty()) {
    const auto comma = words.find(',');
    list.push_back({static_cast<std::uint32_t>(list.size()), std::string(words.substr(0, comma))});
    words.remove_prefix(comma == words.npos ? words.size() : comma + 1);
  }
  return list;
}

bool same_word(std::string_view left, std::string_view right) {
  return std::ranges::equal(left, right, {}, small, small);
}

std::optional<std::uint32_t> number_of(std::string_view text) {
  constexpr std::string_view kReserved = "reserved (";
  if (text.size() > kReserved.size() && same_word(text.substr(0, kReserved.size()), kReserved) && text.ends_with(')'))
    text = text.substr(kReserved.size(), text.size() - kReserved.size() - 1);
  return base::parse_number<std::uint32_t>(text);
}

std::string plain_word(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const char one = small(c);
    if ((one >= 'a' && one <= 'z') || (one >= '0' && one <= '9') || one == '.') out += one;
  }
  return out;
}

Result<std::uint32_t> bits_of(const Words& words, std::string_view text) {
  if (text.size() > kMaxInput) return fail(ErrorCode::kOutOfRange, fmt::format("{} bytes are no value", text.size()));
  const auto json = parse_ordered_json(text);
  if (json.is_discarded()) return bit_named(words, text);
  if (json.is_object()) return bits_in_object(words, json);
  if (json.is_array()) return bits_in_list(words, json);
  if (json.is_string()) return bit_named(words, json.get_ref<const std::string&>());
  return bits_in_number(words, json);
}

Json set_of(const Words& words, std::uint32_t raw) {
  Tree json{{"raw", raw & all_bits(words)}};
  for (const auto& word : words) json[word.text] = (raw & bit(word)) != 0;
  return Json{dump(json)};
}

Result<Value> parse_words(const Type& type, const Words& words, std::string_view text) {
  if (text.size() > kMaxInput) return fail(ErrorCode::kOutOfRange, fmt::format("{}: {} bytes", type.name, text.size()));
  auto value = type.data == DataType::kEnumeration ? enumeration_value(words, text) : set_value(words, text);
  if (!value) return fail(value.error().code, fmt::format("{}: {}", type.name, value.error().text));
  return value;
}

}  // namespace rubicon::model
