#pragma once

#include <cstdint>
#include <span>
#include <string_view>

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

}  // namespace rubicon::networks::knx::dpt
