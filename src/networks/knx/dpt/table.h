#pragma once

#include <span>

#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::dpt {

/// One row; the order is that of Dpt.
constexpr Dpt row(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning,
                  std::string_view unit, std::uint16_t bits, double minimum, double maximum, double step, TypeId sensor,
                  TypeId actuator, Form form, std::span<const Word> words = {}, const StructLayout* record = nullptr) {
  return {{main, sub}, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record};
}

/// The rows of the table, by main type; each sorted by id.
std::span<const Dpt> control_rows();      ///< 1 to 8
std::span<const Dpt> float_rows();        ///< 9 to 14
std::span<const Dpt> text_rows();         ///< 15 to 19
std::span<const Dpt> system_mode_rows();  ///< 20 below 600
std::span<const Dpt> device_mode_rows();  ///< 20 from 600 on
std::span<const Dpt> set_rows();          ///< 21 to 30
std::span<const Dpt> record_rows();       ///< 206 and up
/// The fallbacks for sub types that are not in the table, one for each main type.
std::span<const Dpt> main_rows();

/// 7FFE; 7FFF means "invalid" (KNX 3/7/2, DPT 9).
inline constexpr double kFloat16Maximum = 670433.28;
inline constexpr double kFloat16Minimum = -671088.64;
/// As the table has it: a little above the largest single, which it rounds to.
inline constexpr double kFloat32Maximum = 3.4028235e38;

}  // namespace rubicon::networks::knx::dpt
