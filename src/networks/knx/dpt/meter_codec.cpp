#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "model/json_text.h"
#include "networks/knx/dpt/codec.h"
#include "rubicon/key.hpp"

// 229.001: a count, the code of its unit, the status of 21.001 (knx.md 9.8; KNX 3/7/2).

namespace rubicon::networks::knx::dpt {

namespace {

using Tree = nlohmann::ordered_json;

/// Codes from `first` on mean 10^exponent, 10^(exponent + 1), ... of the unit.
struct MeterUnit {
  std::uint8_t first = 0;
  std::uint8_t count = 8;
  int exponent = 0;
  std::string_view unit;
};
constexpr MeterUnit kUnits[] = {
    {0x00, 8, -3, "Wh"},   {0x08, 8, 0, "J"},     {0x10, 8, -3, "l"},    {0x18, 8, -3, "kg"},
    {0x28, 8, -3, "W"},    {0x30, 8, 0, "J/h"},   {0x38, 8, -3, "l/h"},  {0x40, 8, -4, "l/min"},
    {0x48, 8, -3, "ml/s"}, {0x50, 8, -3, "kg/h"}, {0x6e, 1, 0, "HCA"},   {0x80, 2, -1, "MWh"},
    {0x88, 2, -1, "GJ"},   {0xa8, 2, -1, "MW"},   {0xb0, 2, -1, "GJ/h"}, {0xba, 1, 0, "counts"}};
constexpr std::uint64_t kStatusMask = 0x1f;

const MeterUnit* unit_of(std::uint64_t code) {
  const auto found = std::ranges::find_if(kUnits, [&](const MeterUnit& unit) {
    return code >= unit.first && code < unit.first + std::uint64_t{unit.count};
  });
  return found == std::end(kUnits) ? nullptr : &*found;
}

int exponent_of(const MeterUnit& unit, std::uint64_t code) {
  return unit.exponent + static_cast<int>(code - unit.first);
}

/// Powers of ten divide or multiply exactly, their inverses do not.
double times_ten(double number, int exponent) {
  double factor = 1;
  for (int i = 0; i < std::abs(exponent); ++i) factor *= 10;
  return exponent < 0 ? number / factor : number * factor;
}

std::optional<std::int64_t> count_of(double value, int exponent) {
  const double count = std::floor(times_ten(value, -exponent) + 0.5);
  if (!(count >= -2147483648.0 && count <= 2147483647.0)) return std::nullopt;
  return static_cast<std::int64_t>(count);
}

/// The content of a payload.
struct Reading {
  std::int64_t count = 0;
  std::uint64_t code = 0;
  std::uint64_t status = 0;
};

/// Without a given code: the finest one that can hold the value.
std::optional<Reading> finest(double value, std::string_view name) {
  for (const auto& unit : kUnits) {
    if (unit.unit != name) continue;
    for (int n = 0; n < unit.count; ++n) {
      const auto code = static_cast<std::uint64_t>(unit.first + n);
      if (const auto count = count_of(value, exponent_of(unit, code))) return Reading{*count, code, 0};
    }
  }
  return std::nullopt;
}

Result<Reading> count_and_code(const Dpt& type, const Tree& json) {
  const auto value = json.find("value");
  const auto unit = json.find("unit");
  const auto code = json.find("code");
  if (value == json.end() || !value->is_number()) {
    return fail(ErrorCode::kInvalid, name_of(type) + ": value: expected a number");
  }
  std::optional<Reading> found;
  if (code != json.end()) {
    if (!code->is_number_unsigned() || code->get<std::uint64_t>() > 255) {
      return fail(ErrorCode::kInvalid, name_of(type) + ": code: expected 0 to 255");
    }
    const auto number = code->get<std::uint64_t>();
    const auto* known = unit_of(number);
    const auto count = count_of(value->get<double>(), known ? exponent_of(*known, number) : 0);
    if (count) found = Reading{*count, number, 0};
  } else if (unit != json.end() && unit->is_string()) {
    found = finest(value->get<double>(), unit->get<std::string>());
  }
  if (found) return *found;
  return fail(ErrorCode::kOutOfRange,
              name_of(type) + ": expected a value with a unit such as Wh, l/h or W that can hold it");
}

Result<std::uint64_t> status_of(const Dpt& type, const Tree& json) {
  std::uint64_t status = 0;
  for (const auto& item : json.items()) {
    if (item.key() == "value" || item.key() == "unit" || item.key() == "code") continue;
    const auto found = std::ranges::find_if(type.words, [&](const Word& word) { return word.text == item.key(); });
    if (found == type.words.end() || !item.value().is_boolean()) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: {}: expected value, unit, code, or a bit of the status",
                                                   name_of(type), model::quoted(item.key())));
    }
    if (item.value().get<bool>()) status |= std::uint64_t{1} << found->value;
  }
  return status;
}

}  // namespace

Result<Value> decode_metering(const Dpt& type, ByteView bytes) {
  const auto count = static_cast<std::int32_t>(bits_at(bytes, 0, 32));
  const auto code = bits_at(bytes, 32, 8);
  const auto status = bits_at(bytes, 40, 8) & kStatusMask;
  const auto* unit = unit_of(code);
  Tree json;
  const int exponent = unit ? exponent_of(*unit, code) : 0;
  json["value"] = exponent < 0 ? Tree(times_ten(count, exponent)) : Tree(count * std::llround(times_ten(1, exponent)));
  if (unit) json["unit"] = std::string(unit->unit);
  json["code"] = code;
  for (const auto& word : type.words) json[std::string(word.text)] = (status >> word.value & 1) != 0;
  return Value(Json{model::dump(json)});
}

Result<wire::Payload> encode_metering(const Dpt& type, const Value& value) {
  const auto* text = std::get_if<Json>(&value);
  if (!text) return wrong_kind(type, value, "JSON");
  const auto json = text->text.size() > kMaxJson ? Tree() : model::parse_ordered_json(text->text);
  if (!json.is_object()) return wrong_kind(type, value, "a JSON object");
  const auto reading = count_and_code(type, json);
  if (!reading) return fail(reading.error());
  const auto status = status_of(type, json);
  if (!status) return fail(status.error());
  wire::Payload payload{Bytes(6), false};
  put_bits(payload.bytes, 0, 32, static_cast<std::uint64_t>(reading->count));
  put_bits(payload.bytes, 32, 8, reading->code);
  put_bits(payload.bytes, 40, 8, *status);
  return payload;
}

}  // namespace rubicon::networks::knx::dpt
