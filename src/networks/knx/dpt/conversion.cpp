#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "networks/knx/dpt/codec.h"

#include "base/text.h"

// Between the units and words of KNX and those of the type catalogue.

namespace rubicon::networks::knx::dpt {

namespace {

using model::DataType;

/// (value + shift) * multiply / divide is the value in the catalogue's unit. Two factors, because a quotient by
/// 1000 is correctly rounded and a product with 0.001 is not.
struct Conversion {
  DptId id;
  double multiply = 1, divide = 1;
  double shift = 0;
};

// Sorted by id; all others have the unit of their catalogue type.
constexpr Conversion kConversions[] = {
    {{7, 2}, 1, 1000},      // ms -> s
    {{7, 3}, 1, 1000},      //
    {{7, 4}, 1, 1000},      //
    {{7, 6}, 60, 1},        // min -> s
    {{7, 7}, 3600, 1},      // h -> s
    {{7, 11}, 1, 1000},     // mm -> m
    {{7, 12}, 1, 1000},     // mA -> A
    {{8, 2}, 1, 1000},      // ms -> s
    {{8, 3}, 1, 1000},      //
    {{8, 4}, 1, 1000},      //
    {{8, 6}, 60, 1},        // min -> s
    {{8, 7}, 3600, 1},      // h -> s
    {{9, 11}, 1, 1000},     // ms -> s
    {{9, 20}, 1, 1000},     // mV -> V
    {{9, 21}, 1, 1000},     // mA -> A
    {{9, 24}, 1000, 1},     // kW -> W
    {{9, 25}, 1, 1000},     // l/h -> m3/h
    {{9, 27}, 5, 9, -32},   // degF -> Cel
    {{9, 28}, 5, 18},       // km/h -> m/s
    {{12, 101}, 60, 1},     // min -> s
    {{12, 1200}, 1, 1000},  // l -> m3
    {{13, 10}, 1, 1000},    // Wh -> kW.h
    {{13, 11}, 1, 1000},    // VAh -> kV.A.h
    {{13, 12}, 1, 1000},    // varh -> kvar.h
    {{13, 16}, 1000, 1},    // MWh -> kW.h
    {{13, 1200}, 1, 1000},  // l -> m3
    {{14, 77}, 3600, 1},    // m3/s -> m3/h
    {{14, 1201}, 18, 5},    // l/s -> m3/h
    {{29, 10}, 1, 1000},    // Wh -> kW.h
    {{29, 11}, 1, 1000},    // VAh -> kV.A.h
    {{29, 12}, 1, 1000},    // varh -> kvar.h
};

/// Larger whole numbers are not exact after a conversion: a double holds 15 digits.
constexpr double kMaxExact = 1e15;

const Conversion* conversion_of(DptId id) {
  const auto found = std::ranges::lower_bound(kConversions, id, {}, &Conversion::id);
  return found == std::end(kConversions) || found->id != id ? nullptr : &*found;
}

const model::Type& type_of(const Dpt& type, Kind kind) {
  static const TypeCatalogue catalogue;
  const auto* found = catalogue.find(kind == Kind::kActuator ? type.actuator : type.sensor);
  return *found;  // a test checks that the types of all rows exist
}

/// Rounds to this many digits, to remove rounding errors: 16 towards the catalogue, so that a third converts back, and
/// 15 from the catalogue.
double tidy(double value, int digits) {
  if (value == 0 || !std::isfinite(value)) return value;
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, digits - 1).ptr;
  return base::parse_number<double>({text, end}).value_or(value);
}

double number_of(const Value& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return static_cast<double>(*integer);
  return std::get<double>(value);
}

bool is_number(const Value& value) {
  return std::holds_alternative<std::int64_t>(value) || std::holds_alternative<double>(value);
}

double in_catalogue_unit(const Dpt& type, double number) {
  const auto* conversion = conversion_of(type.id);
  return conversion ? tidy((number + conversion->shift) * conversion->multiply / conversion->divide, 16) : number;
}

Result<Value> real(const Dpt& type, const Value& value) {
  if (!is_number(value)) return wrong_kind(type, value, "a number");
  const auto number = number_of(value);
  if (type.bits == 64 && std::abs(number) > kMaxExact) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: {} has more than 15 digits, which its sensor type cannot hold",
                                                    name_of(type), model::to_text(value)));
  }
  return Value(in_catalogue_unit(type, natural(type, number)));
}

Result<Value> integer_value(const Dpt& type, const Value& value) {
  if (const auto* number = std::get_if<std::int64_t>(&value)) return Value(*number);
  return wrong_kind(type, value, "a whole number");
}

/// The word of a number in a comma separated list of words.
std::string_view word_at(std::string_view words, std::int64_t index) {
  for (; index > 0 && !words.empty(); --index) {
    const auto comma = words.find(',');
    words.remove_prefix(comma == words.npos ? words.size() : comma + 1);
  }
  return index < 0 ? std::string_view() : words.substr(0, words.find(','));
}

/// The number if it has no word, or a word that stands for another number.
Value own_word(const Dpt& type, std::int64_t number) {
  if (type.form != Form::kEnumeration) return Value(number);
  const auto word = word_of(type.words, static_cast<std::uint64_t>(number));
  const bool means_it = !word.empty() && word_value(type.words, word) == static_cast<std::uint32_t>(number);
  return means_it ? Value(std::string(word)) : Value(number);
}

/// The catalogue's word of a number, or the number. If the catalogue type has no words, the KNX word or the number.
Result<Value> catalogue_word(const Dpt& type, const model::Type& target, const Value& value) {
  const auto* number = std::get_if<std::int64_t>(&value);
  if (!number) return wrong_kind(type, value, "a number");
  if (target.words.empty()) return own_word(type, *number);
  const auto word = word_at(target.words, *number);
  return word.empty() ? Value(*number) : Value(std::string(word));
}

Result<Value> converted(const Dpt& type, const model::Type& target, const Value& value) {
  switch (target.data) {
    case DataType::kReal: return real(type, value);
    case DataType::kInteger: return integer_value(type, value);
    case DataType::kEnumeration: return catalogue_word(type, target, value);
    case DataType::kText:
    case DataType::kBytes:
      if (const auto* json = std::get_if<Json>(&value)) return Value(json->text);  // 19.001 with flags
      return value;
    default: return value;
  }
}

Result<Value> number_of_word(const Dpt& type, const model::Type& given, const Value& value) {
  if (std::holds_alternative<std::int64_t>(value)) return value;
  const auto* word = std::get_if<std::string>(&value);
  for (std::int64_t index = 0; word; ++index) {
    const auto at = word_at(given.words, index);
    if (at.empty()) break;
    if (at == *word) return Value(index);
  }
  return wrong_kind(type, value, fmt::format("one of {}", given.words));
}

}  // namespace

double natural(const Dpt& type, double value) {
  if (type.form == Form::kFloat32) return shortest_single(value);
  if (type.id.main != 5 || type.step == std::floor(type.step)) return value;
  const auto octet = [&type](double number) { return std::floor(number / type.step + 0.5); };
  for (const double scale : {1.0, 10.0, 100.0}) {
    const auto rounded = std::round(value * scale) / scale;
    if (octet(rounded) == octet(value) && rounded >= type.minimum && rounded <= type.maximum) return rounded;
  }
  return value;
}

std::optional<Range> range_of(const Dpt& type) {
  const bool number = type.form == Form::kStep || type.form == Form::kPercent || type.form == Form::kAngle ||
                      type.form == Form::kUnsigned || type.form == Form::kSigned || type.form == Form::kHundredths ||
                      type.form == Form::kFloat16 || type.form == Form::kFloat32 || type.form == Form::kScene ||
                      type.form == Form::kEnumeration;
  if (!number) return std::nullopt;
  if (type.form == Form::kStep) return Range{-100, 100};
  return Range{in_catalogue_unit(type, type.minimum), in_catalogue_unit(type, type.maximum)};
}

Result<Value> to_catalogue(const Dpt& type, Kind kind, const Value& value) {
  const auto& target = type_of(type, kind);
  auto result = converted(type, target, value);
  if (!result) return result;
  if (auto fits = TypeCatalogue::check(target, *result); !fits) return fail(fits.error());
  return result;
}

Result<Value> from_catalogue_text(const Dpt& type, std::string_view text) {
  const auto value = TypeCatalogue::parse(type_of(type, Kind::kActuator), text);
  return value ? from_catalogue(type, Kind::kActuator, *value) : value;
}

Result<Value> from_catalogue(const Dpt& type, Kind kind, const Value& value) {
  const auto& given = type_of(type, kind);
  if (type.form == Form::kBits && std::holds_alternative<std::int64_t>(value)) return value;
  if (auto fits = TypeCatalogue::check(given, value); !fits) return fail(fits.error());
  if (given.data == DataType::kEnumeration && !given.words.empty()) return number_of_word(type, given, value);
  const auto* conversion = given.data == DataType::kReal ? conversion_of(type.id) : nullptr;
  if (!conversion) return value;
  return Value(tidy(number_of(value) * conversion->divide / conversion->multiply - conversion->shift, 15));
}

}  // namespace rubicon::networks::knx::dpt
