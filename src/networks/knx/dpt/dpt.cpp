#include "networks/knx/dpt/dpt.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/text.h"
#include "networks/knx/dpt/codec.h"
#include "networks/knx/wire/cemi.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::dpt {

namespace {

/// At most five digits. 65535 means "main type only" and is not a valid number.
std::optional<std::uint16_t> number_of(std::string_view text) {
  if (text.size() > 5) return std::nullopt;
  const auto number = base::parse_number<std::uint16_t>(text);
  return number != DptId::kMainOnly ? number : std::nullopt;
}

bool drop_word(std::string_view& text, std::string_view word) {
  const auto same = [](char a, char b) { return (a >= 'a' && a <= 'z' ? a - 'a' + 'A' : a) == b; };
  if (text.size() < word.size() ||
      !std::equal(word.begin(), word.end(), text.begin(), [same](char b, char a) { return same(a, b); })) {
    return false;
  }
  text.remove_prefix(word.size());
  return true;
}

std::optional<DptId> numbers_of(std::string_view text, char between) {
  const auto cut = text.find(between);
  const auto main = number_of(text.substr(0, cut));
  if (!main || *main == 0) return std::nullopt;
  if (cut == text.npos) return DptId{*main, DptId::kMainOnly};
  const auto rest = text.substr(cut + 1);
  if (rest == "*") return DptId{*main, DptId::kMainOnly};
  const auto sub = number_of(rest);
  if (!sub) return std::nullopt;
  return DptId{*main, *sub};
}

}  // namespace

Result<DptId> parse_dpt(std::string_view text) {
  auto rest = text;
  std::optional<DptId> found;
  if (drop_word(rest, "DPST-")) {
    found = numbers_of(rest, '-');
    if (found && found->sub == DptId::kMainOnly) found.reset();
  } else {
    if (drop_word(rest, "DPT") && rest.starts_with('-')) rest.remove_prefix(1);
    found = numbers_of(rest, '.');
  }
  if (found) return *found;
  return fail(ErrorCode::kInvalid,
              fmt::format("data point type {}: expected 9.001, DPT9.001, DPST-9-1 or DPT-9", model::quoted(text)));
}

std::string to_string(DptId id) {
  if (id.sub == DptId::kMainOnly) return fmt::format("{}.*", id.main);
  return fmt::format("{}.{:03}", id.main, id.sub);
}

namespace {

std::string_view wrong_size(const Dpt& type, wire::PayloadView payload) {
  const bool small = type.bits > 0 && type.bits <= 6;
  if (small != payload.small) return small ? "the small form of up to 6 bits" : "whole octets";
  return "the length of the type";
}

bool has_size(const Dpt& type, wire::PayloadView payload) {
  if (type.bits >= 8) return !payload.small && payload.bytes.size() * 8 == type.bits;
  if (type.bits > 0) return payload.small && payload.bytes.size() == 1;
  return !payload.small && !payload.bytes.empty() && payload.bytes.size() <= wire::kMaxPayload;
}

std::string length_text(const Dpt& type) {
  if (type.bits == 0) return fmt::format("1 to {} octets", wire::kMaxPayload);
  return type.bits < 8 ? fmt::format("{} bits", type.bits) : fmt::format("{} octets", type.bits / 8);
}

std::string step_label(double percent) {
  if (percent == 0) return "stop";
  return fmt::format("{} {} %", percent > 0 ? "increase" : "decrease", std::abs(percent));
}

}  // namespace

Result<Value> decode(const Dpt& type, wire::PayloadView payload) {
  if (!has_size(type, payload)) [[unlikely]] {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} octets{}, expected {} ({})", name_of(type), payload.bytes.size(),
                            payload.small ? " in the small form" : "", length_text(type), wrong_size(type, payload)));
  }
  switch (type.form) {
    case Form::kCharacter:
    case Form::kText:
    case Form::kLongText:
    case Form::kLetters:
    case Form::kColour:
    case Form::kSerial:
    case Form::kIpv6: return decode_text(type, payload.bytes);
    case Form::kTime:
    case Form::kDate:
    case Form::kDateTime: return decode_time(type, payload.bytes);
    case Form::kBits: return decode_bits(type, payload.bytes);
    case Form::kRecord: return decode_record(type, payload.bytes);
    case Form::kMetering: return decode_metering(type, payload.bytes);
    case Form::kRaw: return decode_raw(type, payload.bytes);
    default: return decode_number(type, payload.bytes);
  }
}

Result<wire::Payload> encode(const Dpt& type, const Value& value) {
  switch (type.form) {
    case Form::kCharacter:
    case Form::kText:
    case Form::kLongText:
    case Form::kLetters:
    case Form::kColour:
    case Form::kSerial:
    case Form::kIpv6: return encode_words(type, value);
    case Form::kTime:
    case Form::kDate:
    case Form::kDateTime: return encode_time(type, value);
    case Form::kBits: return encode_bits(type, value);
    case Form::kRecord: return encode_record(type, value);
    case Form::kMetering: return encode_metering(type, value);
    case Form::kRaw: return encode_raw(type, value);
    default: return encode_number(type, value);
  }
}

std::string label(const Dpt& type, const Value& value) {
  const auto* number = std::get_if<std::int64_t>(&value);
  if (const auto* on = std::get_if<bool>(&value); on && type.words.size() == 2) {
    return std::string(type.words[*on ? 1 : 0].text);
  }
  if (const auto* percent = std::get_if<double>(&value); percent && type.form == Form::kStep) {
    return step_label(*percent);
  }
  if (number && type.form == Form::kEnumeration && !type.words.empty()) {
    const auto word = word_of(type.words, static_cast<std::uint64_t>(*number));
    return word.empty() ? fmt::format("reserved ({})", *number) : std::string(word);
  }
  // Panels and ETS number scenes from 1, the wire from 0 (knx.md 9.3).
  if (number && type.form == Form::kScene) return fmt::format("scene {}", *number + 1);
  return model::to_text(value);
}

std::vector<model::Word> words_of(const Dpt& type) {
  std::vector<model::Word> words;
  if (type.form != Form::kEnumeration && type.form != Form::kBits) return words;
  for (const auto& word : type.words) {
    // 20.610 has one word for two numbers; it encodes as the first.
    if (model::value_of_word(words, word.text)) continue;
    words.push_back({word.value, std::string(word.text)});
  }
  return words;
}

std::uint64_t bits_at(ByteView bytes, std::size_t offset, std::size_t count) {
  std::uint64_t raw = 0;
  for (std::size_t bit = offset; bit < offset + count; ++bit) {
    raw = raw << 1 | ((std::uint32_t{bytes[bit / 8]} >> (7 - bit % 8)) & 1U);
  }
  return raw;
}

void put_bits(Bytes& bytes, std::size_t offset, std::size_t count, std::uint64_t raw) {
  for (std::size_t bit = offset + count; bit-- > offset; raw >>= 1) {
    const auto mask = static_cast<std::uint8_t>(0x80U >> (bit % 8));
    auto& byte = bytes[bit / 8];
    byte = static_cast<std::uint8_t>((raw & 1) != 0 ? byte | mask : byte & ~mask);
  }
}

std::string name_of(const Dpt& type) {
  return to_string(type.id) + ' ' + std::string(type.meaning);
}

tl::unexpected<Error> wrong_kind(const Dpt& type, const Value& value, std::string_view expected) {
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: {} is not {}", name_of(type), model::quoted(model::to_text(value)), expected));
}

tl::unexpected<Error> out_of_range(const Dpt& type, double value) {
  const auto unit = type.unit.empty() ? std::string() : ' ' + std::string(type.unit);
  return fail(ErrorCode::kOutOfRange,
              fmt::format("{}: {} is not from {} to {}{}", name_of(type), value, type.minimum, type.maximum, unit));
}

std::string_view word_of(std::span<const Word> words, std::uint64_t value) {
  const auto found = std::ranges::lower_bound(words, value, {}, &Word::value);
  return found == words.end() || found->value != value ? std::string_view() : found->text;
}

}  // namespace rubicon::networks::knx::dpt
