#include "model/units.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "base/text.h"
#include "rubicon/unit.hpp"

namespace rubicon::model {

namespace {

struct Row {
  std::string_view to, from;
  UnitConversion conversion;
};

// By the target, a unit of the catalogue. Factors: The Unified Code for Units of Measure, tables of derived and
// customary units.
constexpr Row kRows[] = {
    {"Cel", "K", {1, 1, -273.15}},
    {"Cel", "[degF]", {5, 9, -32}},
    {"lx", "klx", {1000, 1}},
    {"lx", "lm/m2", {}},
    {"lm", "klm", {1000, 1}},
    {"%", "1", {100, 1}},
    {"[ppm]", "[ppb]", {1, 1000}},
    {"[ppm]", "%", {10000, 1}},
    {"g/m3", "mg/m3", {1, 1000}},
    {"g/m3", "kg/m3", {1000, 1}},
    {"ug/m3", "mg/m3", {1000, 1}},
    {"ug/m3", "ng/m3", {1, 1000}},
    {"ug/m3", "g/m3", {1e6, 1}},
    {"mg/L", "ug/L", {1, 1000}},
    {"mg/L", "g/L", {1000, 1}},
    {"kg/m3", "g/L", {}},
    {"kg/m3", "g/cm3", {1000, 1}},
    {"Bq/m3", "kBq/m3", {1000, 1}},
    {"uS/cm", "mS/cm", {1000, 1}},
    {"uS/cm", "mS/m", {10, 1}},
    {"uS/cm", "S/m", {10000, 1}},
    {"Pa", "hPa", {100, 1}},
    {"Pa", "kPa", {1000, 1}},
    {"Pa", "MPa", {1e6, 1}},
    {"Pa", "mbar", {100, 1}},
    {"Pa", "bar", {100000, 1}},
    {"Pa", "mm[Hg]", {133.322, 1}},
    {"Pa", "[psi]", {6894.757293168361, 1}},
    {"Pa", "atm", {101325, 1}},
    {"Pa/h", "hPa/h", {100, 1}},
    {"Pa/h", "mbar/h", {100, 1}},
    {"mm[Hg]", "kPa", {1000, 133.322}},
    {"mm[Hg]", "Pa", {1, 133.322}},
    {"m/s", "km/h", {5, 18}},
    {"m/s", "cm/s", {1, 100}},
    {"m/s", "mm/s", {1, 1000}},
    {"m/s", "[kn_i]", {1852, 3600}},
    {"m/s", "[mi_i]/h", {1609.344, 3600}},
    {"m/s2", "[g]", {9.80665, 1}},
    {"m/s2", "cm/s2", {1, 100}},
    {"mm/h", "cm/h", {10, 1}},
    {"mm/h", "[in_i]/h", {25.4, 1}},
    {"L/m2", "mm", {}},
    {"m", "mm", {1, 1000}},
    {"m", "cm", {1, 100}},
    {"m", "km", {1000, 1}},
    {"m", "[in_i]", {0.0254, 1}},
    {"m", "[ft_i]", {0.3048, 1}},
    {"m", "[mi_i]", {1609.344, 1}},
    {"m2", "cm2", {1, 10000}},
    {"m2", "km2", {1e6, 1}},
    {"m3", "L", {1, 1000}},
    {"m3", "mL", {1, 1e6}},
    {"m3", "dm3", {1, 1000}},
    {"m3", "cm3", {1, 1e6}},
    {"m3/h", "L/h", {1, 1000}},
    {"m3/h", "L/min", {60, 1000}},
    {"m3/h", "L/s", {3600, 1000}},
    {"m3/h", "m3/s", {3600, 1}},
    {"m3/h", "m3/min", {60, 1}},
    {"kg", "g", {1, 1000}},
    {"kg", "t", {1000, 1}},
    {"kg", "[lb_av]", {0.45359237, 1}},
    {"kg/s", "g/s", {1, 1000}},
    {"kg/s", "kg/h", {1, 3600}},
    {"N", "kN", {1000, 1}},
    {"N", "mN", {1, 1000}},
    {"W", "mW", {1, 1000}},
    {"W", "kW", {1000, 1}},
    {"W", "MW", {1e6, 1}},
    {"W/m2", "kW/m2", {1000, 1}},
    {"V.A", "kV.A", {1000, 1}},
    {"var", "kvar", {1000, 1}},
    {"kW.h", "W.h", {1, 1000}},
    {"kW.h", "MW.h", {1000, 1}},
    {"kW.h", "J", {1, 3.6e6}},
    {"kW.h", "kJ", {1, 3600}},
    {"kW.h", "MJ", {10, 36}},
    {"kW.h", "GJ", {10000, 36}},
    {"kV.A.h", "V.A.h", {1, 1000}},
    {"kvar.h", "var.h", {1, 1000}},
    {"V", "uV", {1, 1e6}},
    {"V", "mV", {1, 1000}},
    {"V", "kV", {1000, 1}},
    {"A", "uA", {1, 1e6}},
    {"A", "mA", {1, 1000}},
    {"A", "kA", {1000, 1}},
    {"Ohm", "kOhm", {1000, 1}},
    {"Ohm", "MOhm", {1e6, 1}},
    {"Hz", "mHz", {1, 1000}},
    {"Hz", "kHz", {1000, 1}},
    {"Hz", "MHz", {1e6, 1}},
    {"Hz", "/min", {1, 60}},
    {"/min", "Hz", {60, 1}},
    {"deg", "rad", {180, std::numbers::pi}},
    {"rad", "deg", {std::numbers::pi, 180}},
    {"rad/s", "deg/s", {std::numbers::pi, 180}},
    {"s", "us", {1, 1e6}},
    {"s", "ms", {1, 1000}},
    {"s", "min", {60, 1}},
    {"s", "h", {3600, 1}},
    {"s", "d", {86400, 1}},
    {"ms", "us", {1, 1000}},
    {"ms", "s", {1000, 1}},
    {"ms", "min", {60000, 1}},
    {"h", "s", {1, 3600}},
    {"h", "min", {1, 60}},
    {"h", "d", {24, 1}},
};

}  // namespace

double UnitConversion::operator()(double value) const {
  const double converted = (value + shift) * multiply / divide;
  if (converted == 0 || !std::isfinite(converted)) return converted;
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, converted, std::chars_format::scientific, 11).ptr;
  return base::parse_number<double>(std::string_view(text, end)).value_or(converted);
}

std::optional<UnitConversion> conversion(std::string_view from, std::string_view to) {
  if (from == to) return UnitConversion{};
  const auto* row = std::find_if(std::begin(kRows), std::end(kRows),
                                 [&](const Row& one) { return one.to == to && one.from == from; });
  return row == std::end(kRows) ? std::nullopt : std::optional(row->conversion);
}

std::string units_of(std::string_view to) {
  std::string units;
  for (const auto& row : kRows) {
    if (row.to != to) continue;
    if (!units.empty()) units += ", ";
    units += row.from;
  }
  return units;
}

namespace {

using Pair = std::pair<std::string_view, std::string_view>;

/// Codes that are read as a whole.
constexpr std::array<Pair, 12> kWhole{{{"1", ""},
                                       {"dB[mW]", "dBm"},
                                       {"mm[Hg]", "mmHg"},
                                       {"W.h", "Wh"},
                                       {"kW.h", "kWh"},
                                       {"MW.h", "MWh"},
                                       {"kvar.h", "kvarh"},
                                       {"V.A", "VA"},
                                       {"kV.A", "kVA"},
                                       {"V.A.h", "VAh"},
                                       {"kV.A.h", "kVAh"},
                                       {"/min", "1/min"}}};

/// One unit of a product or quotient.
constexpr std::array<Pair, 12> kUnits{{{"Cel", "°C"},
                                       {"[degF]", "°F"},
                                       {"[ppm]", "ppm"},
                                       {"[ppb]", "ppb"},
                                       {"[pH]", "pH"},
                                       {"deg", "°"},
                                       {"Ohm", "Ω"},
                                       {"kOhm", "kΩ"},
                                       {"ug", "µg"},
                                       {"uS", "µS"},
                                       {"uR", "µR"},
                                       {"us", "µs"}}};

template <std::size_t N>
const std::string_view* found_in(const std::array<Pair, N>& table, std::string_view code) {
  const auto found = std::find_if(table.begin(), table.end(), [code](const Pair& pair) { return pair.first == code; });
  return found == table.end() ? nullptr : &found->second;
}

std::string one_unit(std::string_view code) {
  std::string_view power;
  if (code.size() > 1 && code.ends_with('2')) power = "²";
  if (code.size() > 1 && code.ends_with('3')) power = "³";
  if (!power.empty()) code.remove_suffix(1);
  const auto* known = found_in(kUnits, code);
  return std::string(known ? *known : code) + std::string(power);
}

}  // namespace

std::string unit_text(std::string_view code) {
  if (const auto* known = found_in(kWhole, code)) return std::string(*known);
  std::string text;
  while (!code.empty()) {
    const auto end = std::min(code.find_first_of("./()"), code.size());
    text += one_unit(code.substr(0, end));
    if (end < code.size()) text += code[end] == '.' ? std::string("·") : std::string(1, code[end]);
    code.remove_prefix(std::min(end + 1, code.size()));
  }
  return text;
}

}  // namespace rubicon::model
