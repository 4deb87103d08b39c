#include "rubicon/unit.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace rubicon::model {

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
