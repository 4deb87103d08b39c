#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

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

}  // namespace rubicon::networks::knx::dpt
