#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "model/point.h"
#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::dpt {

/// The bits of 9.xxx that mean "no valid value" (KNX 3/7/2, DPT 9).
inline constexpr std::uint16_t kInvalidFloat16 = 0x7fff;

/// Sign, 4 bits of exponent, 11 of mantissa in two's complement: M * 2^E hundredths. The caller checks for 7FFF.
inline double float16_value(std::uint16_t raw) {
  const int mantissa = (raw & 0x7ff) - ((raw & 0x8000) != 0 ? 2048 : 0);
  const int exponent = (raw >> 11) & 0xf;
  return static_cast<double>(std::int64_t{mantissa} * (std::int64_t{1} << exponent)) / 100;
}

/// Uses the smallest exponent with which the rounded mantissa fits (knx.md 9.2, rule 5); nullopt outside F800..7FFE.
inline std::optional<std::uint16_t> float16_raw(double value) {
  const double hundredths = value * 100;
  for (int exponent = 0; exponent <= 15; ++exponent) {
    const double mantissa = std::floor(hundredths / (1 << exponent) + 0.5);
    if (!(mantissa >= -2048 && mantissa <= 2047)) continue;
    const auto bits = static_cast<int>(mantissa);
    const auto raw = static_cast<std::uint16_t>((bits < 0 ? 0x8000 : 0) | exponent << 11 | (bits & 0x7ff));
    if (raw == kInvalidFloat16) return std::nullopt;
    return raw;
  }
  return std::nullopt;
}

// The parts of decode() and encode(), by form. Their callers have checked the length of payloads.

Result<Value> decode_number(const Dpt& type, ByteView bytes);
Result<wire::Payload> encode_number(const Dpt& type, const Value& value);
Result<Value> decode_text(const Dpt& type, ByteView bytes);
Result<wire::Payload> encode_words(const Dpt& type, const Value& value);
Result<Value> decode_time(const Dpt& type, ByteView bytes);
Result<wire::Payload> encode_time(const Dpt& type, const Value& value);
Result<Value> decode_record(const Dpt& type, ByteView bytes);
Result<wire::Payload> encode_record(const Dpt& type, const Value& value);
Result<Value> decode_metering(const Dpt& type, ByteView bytes);
Result<wire::Payload> encode_metering(const Dpt& type, const Value& value);
Result<Value> decode_bits(const Dpt& type, ByteView bytes);
Result<wire::Payload> encode_bits(const Dpt& type, const Value& value);
Result<Value> decode_raw(const Dpt& type, ByteView bytes);
Result<wire::Payload> encode_raw(const Dpt& type, const Value& value);

/// Bytes of JSON; no value of a data point type is longer.
inline constexpr std::size_t kMaxJson = 4096;

/// Direction and step code of 3.007 in percent: 100, 50, 25, ... or negative. 0 is a stop; -0 is a stop with the
/// direction bit set, so that it encodes to the same bits.
double step_value(std::uint64_t raw);
/// The nearest step; nullopt outside -100..100.
std::optional<std::uint8_t> step_raw(double percent);

/// The double of the shortest decimal with the same single precision value: 20.48 instead of 20.479999542236328.
double shortest_single(double value);

/// `count` bits (1..64) at `offset` bits from the first bit sent, most significant first.
std::uint64_t bits_at(ByteView bytes, std::size_t offset, std::size_t count);
void put_bits(Bytes& bytes, std::size_t offset, std::size_t count, std::uint64_t raw);

/// `9.001 temperature`, the start of error texts.
std::string name_of(const Dpt& type);
/// The error for a value of the wrong kind.
tl::unexpected<Error> wrong_kind(const Dpt& type, const Value& value, std::string_view expected);
tl::unexpected<Error> out_of_range(const Dpt& type, double value);
/// Text in the words of the type's catalogue type (`protection` of 20.102) -> value of the table.
Result<Value> from_catalogue_text(const Dpt& type, std::string_view text);
/// The value of a number, a word of an enumeration or `reserved (n)`; nullopt for any other text.
inline std::optional<std::uint32_t> word_value(std::span<const Word> words, std::string_view text) {
  return model::value_of_word(words, text);
}
std::string_view word_of(std::span<const Word> words, std::uint64_t value);
using model::same_word;

}  // namespace rubicon::networks::knx::dpt
