#include "networks/knx/dpt/dpt.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "model/key.h"
#include "networks/knx/dpt/codec.h"

namespace rubicon::networks::knx {

namespace {

constexpr std::size_t kMaxPayload = 254;

std::string_view wrong_size(const Dpt& type, PayloadView payload) {
  const bool small = type.bits > 0 && type.bits <= 6;
  if (small != payload.small) return small ? "the small form of up to 6 bits" : "whole octets";
  return "the length of the type";
}

bool has_size(const Dpt& type, PayloadView payload) {
  if (type.bits >= 8) return !payload.small && payload.bytes.size() * 8 == type.bits;
  if (type.bits > 0) return payload.small && payload.bytes.size() == 1;
  return !payload.small && !payload.bytes.empty() && payload.bytes.size() <= kMaxPayload;
}

std::string length_text(const Dpt& type) {
  if (type.bits == 0) return fmt::format("1 to {} octets", kMaxPayload);
  return type.bits < 8 ? fmt::format("{} bits", type.bits) : fmt::format("{} octets", type.bits / 8);
}

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

std::optional<std::uint16_t> number_word(std::string_view text) {
  constexpr std::string_view kReserved = "reserved (";
  if (text.size() > kReserved.size() && same_word(text.substr(0, kReserved.size()), kReserved) && text.ends_with(')')) {
    text = text.substr(kReserved.size(), text.size() - kReserved.size() - 1);
  }
  std::uint16_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Letters, digits and dots only: `not-used` finds `not used`.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const char small = lower(c);
    if ((small >= 'a' && small <= 'z') || (small >= '0' && small <= '9') || small == '.') out += small;
  }
  return out;
}

std::string step_label(double percent) {
  if (percent == 0) return "stop";
  return fmt::format("{} {} %", percent > 0 ? "increase" : "decrease", std::abs(percent));
}

}  // namespace

Result<Value> decode(const Dpt& type, PayloadView payload) {
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

Result<Payload> encode(const Dpt& type, const Value& value) {
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
  // Panels and ETS count scenes from 1, the wire from 0 (knx.md 9.3).
  if (number && type.form == Form::kScene) return fmt::format("scene {}", *number + 1);
  return model::to_text(value);
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

bool same_word(std::string_view left, std::string_view right) {
  return std::ranges::equal(left, right, {}, lower, lower);
}

std::string_view word_of(std::span<const Word> words, std::uint64_t value) {
  const auto found = std::ranges::lower_bound(words, value, {}, &Word::value);
  return found == words.end() || found->value != value ? std::string_view() : found->text;
}

std::optional<std::uint16_t> word_value(std::span<const Word> words, std::string_view text) {
  for (const auto& word : words) {
    if (same_word(word.text, text)) return word.value;
  }
  if (const auto number = number_word(text)) return number;
  std::optional<std::uint16_t> found;
  const auto wanted = plain(text);
  for (const auto& word : words) {
    if (wanted.empty() || plain(word.text) != wanted) continue;
    if (found) return std::nullopt;  // two words differ in blanks only
    found = word.value;
  }
  return found;
}

}  // namespace rubicon::networks::knx
