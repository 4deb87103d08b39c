#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_text.h"
#include "networks/knx/dpt/codec.h"

namespace rubicon::networks::knx::dpt {

/// Bits without a name are reserved.
Result<Value> decode_bits(const Dpt& type, ByteView bytes) {
  return Value(model::set_of(words_of(type), static_cast<std::uint32_t>(bits_at(bytes, 0, type.bits))));
}

Result<wire::Payload> encode_bits(const Dpt& type, const Value& value) {
  const auto* json = std::get_if<Json>(&value);
  if (!json && !std::holds_alternative<std::int64_t>(value)) return wrong_kind(type, value, "JSON or a number");
  const auto text = model::to_text(value);
  if (json && !model::is_json(text)) return wrong_kind(type, value, "JSON");
  const auto raw = model::bits_of(words_of(type), text);
  if (!raw) return fail(raw.error().code, name_of(type) + ": " + raw.error().text);
  wire::Payload payload{Bytes(type.bits / 8), false};
  put_bits(payload.bytes, 0, type.bits, *raw);
  return payload;
}

namespace {

std::uint64_t unsigned_of(ByteView bytes) {
  std::uint64_t raw = 0;
  for (const auto byte : bytes) raw = raw << 8 | byte;
  return raw;
}

std::int64_t signed_of(ByteView bytes) {
  const auto unused = 64 - 8 * bytes.size();
  return static_cast<std::int64_t>(unsigned_of(bytes) << unused) >> unused;
}

bool in_range(const Dpt& type, double value) {
  return value >= type.minimum && value <= type.maximum;
}

Result<Value> real(const Dpt& type, double value) {
  if (!in_range(type, value)) [[unlikely]]
    return out_of_range(type, value);
  return Value(value);
}

Result<Value> integer_value(const Dpt& type, std::int64_t raw) {
  const auto value = type.step == 1 ? raw : raw * static_cast<std::int64_t>(type.step);
  if (!in_range(type, static_cast<double>(value))) [[unlikely]]
    return out_of_range(type, static_cast<double>(value));
  return Value(value);
}

Result<Value> decode_float16(const Dpt& type, ByteView bytes) {
  const auto raw = static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
  if (raw == kInvalidFloat16) [[unlikely]]
    return fail(ErrorCode::kInvalid, name_of(type) + ": 7fff means no valid value");
  return real(type, float16_value(raw));
}

wire::Payload payload_of(const Dpt& type, std::uint64_t raw) {
  if (type.bits < 8) return {{static_cast<std::uint8_t>(raw)}, true};
  wire::Payload payload;
  payload.bytes.resize(type.bits / 8);
  for (auto byte = payload.bytes.rbegin(); byte != payload.bytes.rend(); ++byte, raw >>= 8) {
    *byte = static_cast<std::uint8_t>(raw);
  }
  return payload;
}

/// Scaled numbers are rounded half up, others towards zero (knx.md 9.2, rules 2 and 3).
double raw_number(const Dpt& type, double value) {
  switch (type.form) {
    case Form::kPercent: return std::floor(value * 255 / 100 + 0.5);
    case Form::kAngle: return std::floor(value * 255 / 360 + 0.5);
    case Form::kHundredths: return std::floor(value * 100 + 0.5);
    default: return type.step == 1 ? std::trunc(value) : std::floor(value / type.step + 0.5);
  }
}

float single(double value) {
  constexpr double kMaxSingle = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -kMaxSingle, kMaxSingle));
}

Result<wire::Payload> encode_real(const Dpt& type, double value) {
  if (!in_range(type, value)) return out_of_range(type, value);
  if (type.form == Form::kFloat16) {
    const auto raw = float16_raw(value);
    if (!raw) return out_of_range(type, value);
    return payload_of(type, *raw);
  }
  return payload_of(type, std::bit_cast<std::uint32_t>(single(value)));
}

Result<wire::Payload> encode_whole(const Dpt& type, double value) {
  // The range is checked after truncation: -0.01 of 12.xxx is 0 (knx.md 9.2).
  if (type.bits == 32 && type.minimum == 0 && value > -1 && value < 0) value = 0;
  if (!in_range(type, value) || value >= 9223372036854775808.0) return out_of_range(type, value);
  return payload_of(type, static_cast<std::uint64_t>(static_cast<std::int64_t>(raw_number(type, value))));
}

}  // namespace

double step_value(std::uint64_t raw) {
  const auto code = raw & 7;
  const bool direction = (raw & 8) != 0;
  if (code == 0) return direction ? -0.0 : 0.0;
  const double share = 100.0 / static_cast<double>(1U << (code - 1));
  return direction ? share : -share;
}

std::optional<std::uint8_t> step_raw(double percent) {
  if (!(percent >= -100 && percent <= 100)) return std::nullopt;
  if (percent == 0) return static_cast<std::uint8_t>(std::signbit(percent) ? 8 : 0);
  unsigned best = 1;
  for (unsigned code = 2; code <= 7; ++code) {
    const auto distance = [&](unsigned step) { return std::abs(std::abs(percent) - step_value(8 | step)); };
    if (distance(code) < distance(best)) best = code;
  }
  return static_cast<std::uint8_t>(best | (percent > 0 ? 8U : 0U));
}

double shortest_single(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, static_cast<float>(value)).ptr;
  return base::parse_number<double>({text, end}).value_or(value);
}

Result<Value> decode_number(const Dpt& type, ByteView bytes) {
  switch (type.form) {
    case Form::kBit: return Value((bytes[0] & 1) != 0);
    case Form::kStep: return Value(step_value(bytes[0]));
    case Form::kPercent: return real(type, bytes[0] * 100.0 / 255);
    case Form::kAngle: return real(type, bytes[0] * 360.0 / 255);
    case Form::kHundredths: return real(type, static_cast<double>(signed_of(bytes)) / 100);
    case Form::kFloat16: return decode_float16(type, bytes);
    case Form::kFloat32: return real(type, std::bit_cast<float>(static_cast<std::uint32_t>(unsigned_of(bytes))));
    case Form::kSigned: return integer_value(type, signed_of(bytes));
    case Form::kScene: return integer_value(type, bytes[0] & 0x3f);
    default: break;
  }
  const auto raw = static_cast<std::int64_t>(unsigned_of(bytes));
  return integer_value(type, type.bits < 8 ? raw & ((1 << type.bits) - 1) : raw);
}

Result<wire::Payload> encode_number(const Dpt& type, const Value& value) {
  if (type.form == Form::kBit) {
    const auto* on = std::get_if<bool>(&value);
    if (!on) return wrong_kind(type, value, "off or on");
    return payload_of(type, *on ? 1 : 0);
  }
  const auto* number = std::get_if<std::int64_t>(&value);
  if (number && type.bits == 64) return payload_of(type, static_cast<std::uint64_t>(*number));
  if (type.form == Form::kEnumeration) {
    if (const auto* word = std::get_if<std::string>(&value)) {
      const auto found = word_value(type.words, *word);
      if (!found) return wrong_kind(type, value, "one of its words or a number");
      return encode_whole(type, *found);
    }
  }
  const auto* floating = std::get_if<double>(&value);
  if (!number && !floating) return wrong_kind(type, value, "a number");
  const double given = number ? static_cast<double>(*number) : *floating;
  if (type.form == Form::kStep) {
    const auto raw = step_raw(given);
    if (!raw) return out_of_range(type, given);
    return payload_of(type, *raw);
  }
  if (type.form == Form::kFloat16 || type.form == Form::kFloat32) return encode_real(type, given);
  return encode_whole(type, given);
}

}  // namespace rubicon::networks::knx::dpt
