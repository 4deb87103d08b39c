#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/type_catalogue.h"
#include "networks/knx/dpt/convert_line.h"
#include "networks/knx/dpt/samples.h"

namespace rubicon::networks::knx::dpt {
namespace {

constexpr std::size_t kRandom = 400;

/// What a payload is when its reserved bits are 0 and its floats are in the one form that is sent.
wire::Payload settled(const Dpt& type, const wire::Payload& payload) {
  const auto value = decode(type, payload);
  return value ? encode(type, *value).value_or(wire::Payload{}) : wire::Payload{};
}

/// Bits that no decoder looks at: changing one changes no value.
Bytes reserved_bits(const Dpt& type) {
  Bytes mask((type.bits + 7U) / 8U);
  const auto samples = payloads_of(type, 40);
  const auto stride = std::max<std::size_t>(1, samples.size() / 40) | 1U;
  for (std::size_t bit = 0; bit < mask.size() * 8; ++bit) {
    bool matters = false;
    for (std::size_t i = 0; i < samples.size() && !matters; i += stride) {
      auto other = samples[i];
      other.bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      const auto one = decode(type, samples[i]);
      const auto two = decode(type, other);
      matters = one.has_value() != two.has_value() || (one && *one != *two);
    }
    if (!matters) mask[bit / 8] |= static_cast<std::uint8_t>(1U << (bit % 8));
  }
  return mask;
}

bool is_float16(const Dpt& type) {
  if (type.form == Form::kFloat16) return true;
  return type.record && !type.record->fields.empty() && type.record->fields[0].kind == FieldKind::kFloat16;
}

bool is_text(const Dpt& type) {
  return type.form == Form::kText || type.form == Form::kLongText;
}

/// ISO 8859-1 in a type of ASCII: it is read and never sent.
bool is_foreign_text(const Dpt& type, const wire::Payload& sample) {
  const bool ascii = (is_text(type) || type.form == Form::kCharacter) && type.maximum == 127;
  return ascii && std::ranges::any_of(sample.bytes, [](std::uint8_t byte) { return byte > 127; });
}

TEST(DptRoundTrip, EncodingWhatWasDecodedGivesTheSameBits) {
  for (const auto* type : all_and_mains()) {
    SCOPED_TRACE(to_string(type->id));
    const auto reserved =
        is_text(*type) || is_float16(*type) || type->form == Form::kStep || type->form == Form::kLetters
            ? Bytes()
            : reserved_bits(*type);
    std::size_t decoded = 0;
    for (const auto& sample : payloads_of(*type, kRandom)) {
      const auto value = decode(*type, sample);
      if (!value || is_foreign_text(*type, sample)) continue;
      ++decoded;
      const auto sent = encode(*type, *value);
      ASSERT_TRUE(sent) << base::to_hex(sample.bytes) << ": " << sent.error().text;
      ASSERT_EQ(*decode(*type, *sent), *value) << base::to_hex(sample.bytes) << " -> " << base::to_hex(sent->bytes);
      if (reserved.empty()) continue;
      auto expected = sample;
      for (std::size_t i = 0; i < reserved.size(); ++i) expected.bytes[i] &= static_cast<std::uint8_t>(~reserved[i]);
      ASSERT_EQ(sent->bytes, expected.bytes);
    }
    EXPECT_GT(decoded, 0U);
  }
}

TEST(DptRoundTrip, BothStopsOfAStepStayWhatTheyAre) {
  for (const auto* name : {"3.007", "3.008", "3.999"}) {
    const auto& type = dpt(name);
    for (unsigned raw = 0; raw < 16; ++raw) {
      const wire::Payload sample{{static_cast<std::uint8_t>(raw)}, true};
      EXPECT_EQ(settled(type, sample), sample) << name << ' ' << raw;
    }
  }
}

TEST(DptRoundTrip, ASmallestExponentIsTheFormOfAFloat) {
  const auto& type = dpt("9.002");
  std::size_t same = 0;
  for (const auto& sample : payloads_of(type, 0)) {
    if (sample.bytes == Bytes{0x7f, 0xff}) continue;
    const auto sent = settled(type, sample);
    const int exponent = sample.bytes[0] >> 3 & 0xf;
    const int mantissa = ((sample.bytes[0] & 7) << 8 | sample.bytes[1]) - (sample.bytes[0] & 0x80 ? 2048 : 0);
    const bool smallest = exponent == 0 || mantissa < -1024 || mantissa > 1023;
    if (smallest) {
      ASSERT_EQ(sent, sample) << base::to_hex(sample.bytes);
      ++same;
    }
  }
  EXPECT_GT(same, 30000U);
}

TEST(DptRoundTrip, TextIsTheSameUpToItsEnd) {
  for (const auto* name : {"16.000", "16.001", "24.001", "28.001"}) {
    const auto& type = dpt(name);
    for (const auto& sample : payloads_of(type, kRandom)) {
      const auto value = decode(type, sample);
      if (!value || is_foreign_text(type, sample)) continue;
      auto expected = sample.bytes;
      const auto end = std::ranges::find(expected, 0);
      if (type.form == Form::kText) std::fill(end, expected.end(), std::uint8_t{0});
      if (type.form == Form::kLongText) {
        expected.erase(end, expected.end());
        expected.push_back(0);
      }
      ASSERT_EQ(base::to_hex(settled(type, sample).bytes), base::to_hex(expected));
    }
  }
}

TEST(DptRoundTrip, TheLinesOfTheToolReadEachOther) {
  for (const auto* type : all_and_mains()) {
    const auto name = to_string(type->id);
    const auto samples = payloads_of(*type, 60);
    for (std::size_t i = 0; i<samples.size(); i += samples.size()> 1000 ? 331U : 1U) {
      if (is_foreign_text(*type, samples[i])) continue;
      const auto hex = base::to_hex(samples[i].bytes);
      const auto text = decode_line(name + ' ' + hex);
      ASSERT_EQ(text.find('\n'), text.npos);
      if (text.starts_with("error: ")) {
        EXPECT_FALSE(decode(*type, samples[i]));
        continue;
      }
      ASSERT_EQ(encode_line(name + ' ' + text), base::to_hex(settled(*type, samples[i]).bytes)) << name << ' ' << text;
    }
  }
}

TEST(DptCatalogue, EveryValueInRangeComesThroughAndBack) {
  const TypeCatalogue types;
  for (const auto* type : all_and_mains()) {
    for (const auto kind : {Kind::kSensor, Kind::kActuator}) {
      if (kind == Kind::kActuator && type->actuator == type->sensor) continue;
      SCOPED_TRACE(to_string(type->id));
      const auto& target = *types.find(kind == Kind::kSensor ? type->sensor : type->actuator);
      std::size_t fitting = 0;
      for (const auto& sample : payloads_of(*type, kRandom)) {
        const auto value = decode(*type, sample);
        if (!value || is_foreign_text(*type, sample)) continue;
        const auto converted = to_catalogue(*type, kind, *value);
        if (!converted) {
          ASSERT_EQ(converted.error().code, ErrorCode::kOutOfRange) << converted.error().text;
          continue;
        }
        ++fitting;
        ASSERT_TRUE(TypeCatalogue::check(target, *converted));
        const auto back = from_catalogue(*type, kind, *converted);
        ASSERT_TRUE(back) << back.error().text;
        const auto sent = encode(*type, *back);
        ASSERT_TRUE(sent) << sent.error().text;
        if (sent->bytes != sample.bytes) {
          ASSERT_EQ(sent->bytes, settled(*type, sample).bytes) << model::to_text(*converted);
        }
        if (fitting % 61 != 0) continue;
        // As a command would give it.
        const auto parsed = TypeCatalogue::parse_reading(target, model::to_text(*converted));
        ASSERT_TRUE(parsed) << parsed.error().text;
        if (std::holds_alternative<double>(*value) && std::signbit(std::get<double>(*value))) continue;  // -0 becomes 0
        ASSERT_EQ(*encode(*type, *from_catalogue(*type, kind, *parsed)), *sent) << model::to_text(*converted);
      }
      EXPECT_GT(fitting, 0U);
    }
  }
}

TEST(DptCatalogue, OnlyTypesWithALimitedRangeRefuseValues) {
  const TypeCatalogue types;
  for (const auto* type : all_and_mains()) {
    const auto& target = *types.find(type->sensor);
    const bool limited = std::isfinite(target.minimum) || std::isfinite(target.maximum) ||
                         target.data == model::DataType::kEnumeration || type->bits == 64;
    if (limited) continue;
    const auto samples = payloads_of(*type, 200);
    for (std::size_t i = 0; i<samples.size(); i += samples.size()> 1000 ? 61U : 1U) {
      const auto value = decode(*type, samples[i]);
      if (value) {
        EXPECT_TRUE(to_catalogue(*type, Kind::kSensor, *value)) << to_string(type->id);
      }
    }
  }
}

TEST(DptCatalogue, TheBoundsOfANumberAreThoseThatATelegramTakes) {
  const TypeCatalogue types;
  std::size_t held = 0;
  for (const auto* type : all_and_mains()) {
    const auto range = range_of(*type);
    if (!range) continue;
    const bool whole = types.find(type->actuator)->data != model::DataType::kReal;
    const auto sent = [&](double number) -> Result<wire::Payload> {
      const auto value =
          from_catalogue(*type, Kind::kActuator, whole ? Value(static_cast<std::int64_t>(number)) : Value(number));
      return value ? encode(*type, *value) : Result<wire::Payload>(fail(value.error()));
    };
    for (const auto& [bound, beyond] : {std::pair(range->minimum, -1), std::pair(range->maximum, 1)}) {
      if (std::abs(bound) >= 1e15 || !sent(bound)) continue;  // the type of the catalogue is narrower
      ++held;
      const auto outside = sent(bound + beyond * std::max(100.0, std::abs(bound) / 100));
      ASSERT_FALSE(outside) << to_string(type->id) << " takes more than " << bound;
      EXPECT_EQ(outside.error().code, ErrorCode::kOutOfRange) << to_string(type->id);
    }
  }
  EXPECT_GT(held, 200U);
  EXPECT_EQ(range_of(dpt("5.001"))->maximum, 100);
  EXPECT_NEAR(range_of(dpt("9.027"))->minimum, -273.11, 0.01) << "degrees Fahrenheit become Celsius";
  EXPECT_FALSE(range_of(dpt("1.001")));
}

TEST(DptDecode, NeverReadsBeyondThePayload) {
  for (const auto* type : all_and_mains()) {
    for (std::size_t length = 0; length <= 20; ++length) {
      for (const bool small : {false, true}) {
        // Of its own, so that the sanitizer sees a step beyond it.
        const Bytes bytes(length, 0x01);
        const auto value = decode(*type, wire::PayloadView{bytes, small});
        const bool right =
            type->bits == 0 ? length > 0 && !small : small == (type->bits <= 6) && length == (type->bits + 7U) / 8U;
        if (!right) {
          ASSERT_FALSE(value) << to_string(type->id) << ' ' << length;
          EXPECT_EQ(value.error().code, ErrorCode::kInvalid);
        }
      }
    }
  }
}

}  // namespace
}  // namespace rubicon::networks::knx::dpt
