#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/point.h"
#include "model/type_catalogue.h"
#include "model/value.h"
#include "networks/knx/wire/cemi.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::knx::dpt {

/// How the payload of a data point type is built (KNX 3/7/2); main types in brackets.
enum class Form : std::uint8_t {
  kBit,          ///< one bit (1)
  kStep,         ///< direction and step code, as a signed percentage (3.007)
  kPercent,      ///< U8, 100/255 (5.001)
  kAngle,        ///< U8, 360/255 (5.003)
  kUnsigned,     ///< 4 to 32 bits, times the step (5, 7, 12)
  kSigned,       ///< 8 to 64 bits, times the step (6, 8, 13, 29)
  kHundredths,   ///< V16, 0.01 (8.010)
  kFloat16,      ///< sign, exponent, mantissa of KNX (9)
  kFloat32,      ///< IEEE single (14)
  kScene,        ///< U6 below two reserved bits (17)
  kEnumeration,  ///< one number, named by words (20, 23)
  kBits,         ///< set of bits, named by words (21, 22, 30)
  kCharacter,    ///< one character (4)
  kText,         ///< 14 octets, NUL padded (16)
  kLongText,     ///< of variable length, NUL terminated (24, 28)
  kLetters,      ///< language and region codes (231, 234)
  kTime,         ///< day of the week and time (10)
  kDate,         ///< (11)
  kDateTime,     ///< date, time and flags (19)
  kColour,       ///< three octets (232)
  kSerial,       ///< manufacturer and number (221)
  kIpv6,         ///< (285)
  kRecord,       ///< fields, as JSON
  kMetering,     ///< count, unit code and status (229)
  kRaw,          ///< unknown layout, as the sub type is unknown: the octets as hex in JSON
};

/// The name of a value of an enumeration or of one bit, or of a bit in a set (0 = lowest).
struct Word {
  std::uint16_t value = 0;
  std::string_view text;
};

/// The encoding of a field of a structure.
enum class FieldKind : std::uint8_t {
  kFlag,      ///< true or false
  kInverse,   ///< true where the bit is 0
  kUnsigned,  ///< scaled
  kSigned,    ///< scaled
  kFloat16,
  kFloat32,
  kStep,   ///< as Form::kStep
  kWords,  ///< a word, or the number if it has none
  kHex,    ///< digits of 4 bits each
};

/// One field of a structure.
struct Field {
  std::string_view name;
  std::uint8_t offset = 0;  ///< bits from the first bit sent
  std::uint8_t bits = 1;
  FieldKind kind = FieldKind::kFlag;
  double multiply = 1, divide = 1;  ///< raw * multiply / divide = value
  double minimum = 0, maximum = 0;  ///< both 0 = all values of the bits
  std::int8_t validity = -1;        ///< index in StructLayout::validities; -1 = always valid
  std::span<const Word> words{};
};

/// A bit that marks fields as valid.
struct Validity {
  std::string_view name;  ///< `brightnessValid`: in the JSON only if it does not follow from the presence of the fields
  std::uint8_t offset = 0;
  bool inverse = false;  ///< 1 = not valid
};

/// Layout of a structure (knx.md 9.8, from KNX 3/7/2).
struct StructLayout {
  std::span<const Field> fields;
  std::span<const Validity> validities{};
};

/// Number of a data point type. Without a sub type (`9`, `9.*`, `DPT-9`) it means the main type only.
struct DptId {
  static constexpr std::uint16_t kMainOnly = 0xffff;
  std::uint16_t main = 0;
  std::uint16_t sub = kMainOnly;

  friend auto operator<=>(const DptId&, const DptId&) = default;
};

/// `9.001`, `9.1`, `DPT9.001`, `DPT-9`, `DPST-9-1`, `9`, `9.*`; kInvalid for anything else. The type need not exist.
Result<DptId> parse_dpt(std::string_view text);
/// `9.001`; `9.*` for a main type.
std::string to_string(DptId id);

/// One data point type: a row of the table (KNX 3/7/2; master data of ETS 6), or the fallback of a main type for
/// unknown sub types.
struct Dpt {
  DptId id;
  std::string_view name;            ///< `DPT_Value_Temp`
  std::string_view meaning;         ///< `temperature`
  std::string_view unit;            ///< of the KNX table: `°C`; empty = none
  std::uint16_t bits = 0;           ///< of the payload; 0 = text of variable length; up to 6 bits use the small form
  double minimum = 0, maximum = 0;  ///< of number types, in `unit`
  double step = 0;                  ///< resolution in `unit`; 0 = no number, or a float
  TypeId sensor{}, actuator{};      ///< its types in the catalogue, as a sensor and as an actuator
  Form form = Form::kRaw;
  std::span<const Word> words{};         ///< of a bit, an enumeration, a set of bits; sorted by value
  const StructLayout* record = nullptr;  ///< of Form::kRecord
};

/// All rows, sorted by id (363).
std::span<const Dpt> all_dpts();
/// The row, or the fallback of the main type (with the id `9.*`); nullptr for an unknown main type. Private rows
/// (numbers that one library invented) are found only by their full number.
const Dpt* find_dpt(DptId id);

/// Payload -> value in the unit of the table, exact per resolution. kInvalid: wrong length or form, undecodable (7FFF
/// of 9.xxx); kOutOfRange: outside the bounds of the type. Numbers are double or int64, one bit is bool, enumerations
/// are their number, times and texts are text, sets of bits and records JSON. No allocation for numeric types.
Result<Value> decode(const Dpt& type, wire::PayloadView payload);
/// The inverse; kOutOfRange outside the bounds (never clamped), kInvalid for a value of another kind.
Result<wire::Payload> encode(const Dpt& type, const Value& value);
/// Encodes text of a user: numbers, on/off and the words of the type, times, JSON.
Result<wire::Payload> encode_text(const Dpt& type, std::string_view text);
/// The words of an enumeration, each once, or the names of the bits of a set; empty for others.
std::vector<model::Word> words_of(const Dpt& type);
/// The word of a value where the type has words (`comfort`, `down`, `reserved (7)`), else its text.
std::string label(const Dpt& type, const Value& value);

/// The shortest decimal with the same payload, for display: 50 instead of 50.19607843137255 of scaled octets (5.001,
/// 5.003), 24.3 instead of 24.299999237060547 of singles (14.xxx). Other numbers are returned unchanged.
double natural(const Dpt& type, double value);

/// Bounds of a number.
struct Range {
  double minimum = 0, maximum = 0;
};
/// The range of a number type in the unit of its catalogue type; nullopt if its values are not numbers.
std::optional<Range> range_of(const Dpt& type);

/// Value in the table's unit -> value in the unit and words of its catalogue type for `kind`, and
/// back.
Result<Value> to_catalogue(const Dpt& type, Kind kind, const Value& value);
Result<Value> from_catalogue(const Dpt& type, Kind kind, const Value& value);

}  // namespace rubicon::networks::knx::dpt
