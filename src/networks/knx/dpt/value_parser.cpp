#include <fmt/format.h>

#include <cmath>

#include "base/text.h"
#include "networks/knx/dpt/codec.h"
#include "rubicon/key.hpp"

// Values as text, as users write them.

namespace rubicon::networks::knx::dpt {

namespace {

template <class Number>
std::optional<Number> number_in(std::string_view text) {
  if (text.starts_with('+') && text.size() > 1 && text[1] != '-') text.remove_prefix(1);
  return base::parse_number<Number>(text);
}

/// Removes the word if the text begins with it: `learn 5` -> `5`.
bool drop_leading_word(std::string_view& text, std::string_view word) {
  if (text.size() <= word.size() || !same_word(text.substr(0, word.size()), word)) return false;
  if (text[word.size()] != ' ' && text[word.size()] != ',') return false;
  text.remove_prefix(word.size() + 1);
  text = base::trimmed(text);
  return true;
}

tl::unexpected<Error> unreadable(const Dpt& type, std::string_view text, std::string_view expected) {
  return fail(ErrorCode::kInvalid, fmt::format("{}: {} is not {}", name_of(type), model::quoted(text), expected));
}

/// Compares with the word of 1 first: both words of 1.017 are `trigger`.
std::optional<bool> bit_in(const Dpt& type, std::string_view text) {
  if (type.words.size() == 2) {
    if (same_word(text, type.words[1].text)) return true;
    if (same_word(text, type.words[0].text)) return false;
  }
  for (const auto word : {"on", "true", "1"}) {
    if (same_word(text, word)) return true;
  }
  for (const auto word : {"off", "false", "0"}) {
    if (same_word(text, word)) return false;
  }
  return std::nullopt;
}

Result<wire::Payload> encode_bit(const Dpt& type, std::string_view text) {
  if (const auto on = bit_in(type, text)) return encode(type, *on);
  if (const auto on = from_catalogue_text(type, text)) return encode(type, *on);
  return unreadable(type, text, fmt::format("{} or {} (or off, on)", type.words[0].text, type.words[1].text));
}

/// `increase 3`, `down 1`: a direction and a step code; `stop`.
struct StepText {
  bool direction = false;
  std::uint8_t code = 0;
};

std::optional<StepText> step_in(std::string_view text) {
  if (same_word(text, "stop")) return StepText{};
  StepText step;
  if (drop_leading_word(text, "increase")) {
    step.direction = true;
  } else if (!drop_leading_word(text, "decrease")) {
    return std::nullopt;
  }
  const auto code = number_in<std::uint8_t>(text);
  if (!code || *code > 7) return std::nullopt;
  step.code = *code;
  return step;
}

Result<wire::Payload> encode_step(const Dpt& type, std::string_view text) {
  if (const auto step = step_in(text)) {
    return wire::Payload{{static_cast<std::uint8_t>((step->direction ? 8 : 0) | step->code)}, true};
  }
  if (text.ends_with('%')) text = base::trimmed(text.substr(0, text.size() - 1));
  if (const auto number = number_in<double>(text)) return encode(type, *number);
  return unreadable(type, text, "a number from -100 to 100, stop, increase 3 or decrease 3");
}

Result<wire::Payload> encode_figure(const Dpt& type, std::string_view text) {
  auto figure = text;
  if (!type.unit.empty() && figure.ends_with(type.unit)) {
    figure = base::trimmed(figure.substr(0, figure.size() - type.unit.size()));
  }
  if (type.bits == 64) {
    if (const auto integer = number_in<std::int64_t>(figure)) return encode(type, *integer);
  }
  const auto number = number_in<double>(figure);
  if (!number || !std::isfinite(*number)) return unreadable(type, text, "a number");
  return encode(type, *number);
}

/// Short spellings of records: `control, on`, `down 1`, `learn 5`, `1.2.3`.
std::string json_of(const Dpt& type, std::string_view text) {
  if (type.id.main == 2) {
    const bool free = drop_leading_word(text, "no control");
    const bool control = !free && drop_leading_word(text, "control");
    const auto on = bit_in(type, text);
    if (on && (free || control)) return fmt::format(R"({{"control":{},"value":{}}})", control, *on);
  }
  if (type.id.main == 3) {
    if (same_word(text, "stop")) return R"({"direction":"up","code":0})";
    const bool down = drop_leading_word(text, "down");
    if (!down && !drop_leading_word(text, "up")) return {};
    if (const auto code = number_in<std::uint8_t>(text)) {
      return fmt::format(R"({{"direction":"{}","code":{}}})", down ? "down" : "up", *code);
    }
  }
  if (type.id.main == 18) {
    const bool learn = drop_leading_word(text, "learn");
    if (const auto scene = number_in<std::uint8_t>(text)) {
      return fmt::format(R"({{"learn":{},"scene":{}}})", learn, *scene);
    }
  }
  return {};
}

std::string version_json(std::string_view text) {
  const auto first = text.find('.');
  const auto second = first == text.npos ? first : text.find('.', first + 1);
  if (second == text.npos) return {};
  const auto magic = number_in<std::uint8_t>(text.substr(0, first));
  const auto version = number_in<std::uint8_t>(text.substr(first + 1, second - first - 1));
  const auto revision = number_in<std::uint8_t>(text.substr(second + 1));
  if (!magic || !version || !revision) return {};
  return fmt::format(R"({{"magic":{},"version":{},"revision":{}}})", *magic, *version, *revision);
}

Result<wire::Payload> encode_structure(const Dpt& type, std::string_view text) {
  if (text.starts_with('{')) return encode(type, Json{std::string(text)});
  const auto json = type.id.main == 217 ? version_json(text) : json_of(type, text);
  if (json.empty()) return unreadable(type, text, "a JSON object");
  return encode(type, Json{json});
}

/// A number, a JSON object of bits, or the name of one bit.
Result<wire::Payload> encode_set(const Dpt& type, std::string_view text) {
  const auto raw = model::bits_of(words_of(type), text);
  if (!raw) return fail(raw.error().code, name_of(type) + ": " + raw.error().text);
  return encode(type, std::int64_t{*raw});
}

/// Also accepts the words of the type catalogue; those of the KNX type have priority.
Result<wire::Payload> encode_word(const Dpt& type, std::string_view text) {
  auto own = encode(type, std::string(text));
  const auto converted = own ? Result<Value>(fail(ErrorCode::kInvalid, "")) : from_catalogue_text(type, text);
  return converted ? encode(type, *converted) : own;
}

}  // namespace

Result<wire::Payload> encode_text(const Dpt& type, std::string_view text) {
  switch (type.form) {
    case Form::kCharacter:
    case Form::kText:
    case Form::kLongText: return encode(type, std::string(text));
    default: break;
  }
  const auto given = base::trimmed(text);
  switch (type.form) {
    case Form::kBit: return encode_bit(type, given);
    case Form::kStep: return encode_step(type, given);
    case Form::kBits: return encode_set(type, given);
    case Form::kRecord:
    case Form::kMetering:
    case Form::kRaw: return encode_structure(type, given);
    case Form::kEnumeration: return encode_word(type, given);
    case Form::kLetters:
    case Form::kColour:
    case Form::kSerial:
    case Form::kIpv6:
    case Form::kTime:
    case Form::kDate: return encode(type, std::string(given));
    case Form::kDateTime:
      return given.starts_with('{') ? encode(type, Json{std::string(given)}) : encode(type, std::string(given));
    default: return encode_figure(type, given);
  }
}

}  // namespace rubicon::networks::knx::dpt
