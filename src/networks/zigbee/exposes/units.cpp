#include "networks/zigbee/exposes/units.h"

#include <algorithm>
#include <initializer_list>
#include <iterator>

#include "base/text.h"

namespace rubicon::networks::zigbee::exposes {

namespace {

struct Spelling {
  std::string_view spelling, code;
  double multiply = 1, divide = 1, shift = 0;
};

// zigbee.md, section 11. Codes are those of UCUM where it has one.
constexpr Spelling kSpellings[] = {
    {"", ""},
    {"°C", "Cel"},
    {"C", "Cel"},
    {"℃", "Cel"},
    {"ºC", "Cel"},
    {"°F", "Cel", 5, 9, -32},
    {"℉", "Cel", 5, 9, -32},
    {"K", "K"},
    {"mired", "mired"},
    {"%", "%"},
    {"‰", "%", 1, 10},
    {"s", "s"},
    {"sec", "s"},
    {"seconds", "s"},
    {"Sec", "s"},
    {"Seconds", "s"},
    {"sec.", "s"},
    {"S", "s"},  // seconds, not siemens
    {"ms", "s", 1, 1000},
    {"10 ms", "s", 1, 100},
    {"10s", "s", 10},
    {"min", "s", 60},
    {"minutes", "s", 60},
    {"minute", "s", 60},
    {"min.", "s", 60},
    {"h", "s", 3600},
    {"Hours", "s", 3600},
    {"hours", "s", 3600},
    {"hour", "s", 3600},
    {"Hr", "s", 3600},
    {"H", "s", 3600},  // hours, not henry
    {"day", "s", 86400},
    {"days", "s", 86400},
    {"Day", "s", 86400},
    {"d", "s", 86400},
    {"month", "mo"},
    {"year", "a"},
    {"m", "m"},
    {"meters", "m"},
    {"cm", "m", 1, 100},
    {"mm", "m", 1, 1000},
    {"µm", "m", 1, 1e6},
    {"m/s", "m/s"},
    {"mm/s", "m/s", 1, 1000},
    {"mm/h", "mm/h"},
    {"W", "W"},
    {"w", "W"},
    {"watt", "W"},
    {"kW", "W", 1000},
    {"kWh", "kW.h"},
    {"Wh", "kW.h", 1, 1000},
    {"VA", "V.A"},
    {"kVA", "V.A", 1000},
    {"VAR", "var"},
    {"VAr", "var"},
    {"kVArh", "kvar.h"},
    {"VArh", "kvar.h", 1, 1000},
    {"V", "V"},
    {"volt", "V"},
    {"Volt", "V"},
    {"mV", "V", 1, 1000},
    {"A", "A"},
    {"mA", "A", 1, 1000},
    {"Hz", "Hz"},
    {"lx", "lx"},
    {"lux", "lx"},
    {"Lx", "lx"},
    {"ppm", "[ppm]"},
    {"ppb", "[ppm]", 1, 1000},
    {"µg/m³", "ug/m3"},
    {"ug/m3", "ug/m3"},
    {"mg/m³", "ug/m3", 1000},
    {"mg/L", "mg/L"},
    {"#/cm³", "/cm3"},
    {"hPa", "Pa", 100},
    {"kPa", "Pa", 1000},
    {"bar", "Pa", 100000},
    {"psi", "Pa", 6894.757},
    {"hPa/h", "Pa/h", 100},
    {"m³", "m3"},
    {"m3", "m3"},
    {"L", "m3", 1, 1000},
    {"liter", "m3", 1, 1000},
    {"gal", "m3", 3.785412, 1000},
    {"m³/h", "m3/h"},
    {"L/h", "m3/h", 1, 1000},
    {"gal/min", "m3/h", 0.2271247},
    {"g", "g"},
    {"μS/cm", "uS/cm"},  // Greek letter
    {"µS/cm", "uS/cm"},  // micro sign
    {"°", "deg"},
    {"*", "deg"},  // the degree sign was lost
    {"rpm", "/min"},
    {"breaths/min", "/min"},
    {"μR/h", "uR/h"},
    {"dB", "dB"},
    {"dBA", "dB"},
    {"dBm", "dB[mW]"},
    {"dB/m", "dB/m"},
    {"%LEL", "%{LEL}"},
    {"LEL %", "%{LEL}"},
    {"LEL", "%{LEL}"},
    {"pH", "[pH]"},
    {"VOC Index points", "{index}"},
    {"VOC index points", "{index}"},
    {"NOx Index points", "{index}"},
    {"PM2.5 Index", "{index}"},
    {"index", "{index}"},
    {"raw unit", "{raw}"},
    {"raw", "{raw}"},
    {"adc", "{raw}"},
    {"times", "{count}"},
    {"portion", "{count}"},
    {"x", "{count}"},
    {"level", "{level}"},
    {"lqi", "{level}"},
};

const Spelling* find(std::string_view spelling) {
  const auto* found = std::find_if(std::begin(kSpellings), std::end(kSpellings),
                                   [&](const Spelling& row) { return row.spelling == spelling; });
  return found == std::end(kSpellings) ? nullptr : found;
}

bool has_any(std::string_view name, std::initializer_list<std::string_view> parts) {
  return std::any_of(parts.begin(), parts.end(), [&](std::string_view part) { return name.find(part) != name.npos; });
}

bool is_temperature_difference(std::string_view name) {
  return has_any(name, {"calibration", "offset", "hysteresis", "hysterersis", "deadband", "deadzone", "setback",
                        "sensitivity", "delta", "correction", "compensation"});
}

bool is_minutes(std::string_view name) {
  return has_any(name, {"minute", "countdown", "delay", "periode"}) || name.ends_with("_time");
}

/// A field of a clock or a calendar is a number of hours, minutes or days as it is, not a duration.
std::optional<LeafUnit> calendar_field(const Spelling& row, std::string_view name, std::optional<double> maximum) {
  const bool minutes = row.spelling == "m" || row.multiply == 60;
  const bool hours = row.multiply == 3600;
  if (minutes && name.ends_with("minute") && maximum.value_or(59) <= 60) return LeafUnit{"min"};
  if (hours && (maximum == 23 || name.ends_with("_hour") || name == "hour")) return LeafUnit{"h"};
  if (row.multiply == 86400 && name.ends_with("day") && maximum.value_or(31) == 31) return LeafUnit{"d"};
  return std::nullopt;
}

}  // namespace

LeafUnit unit_of(std::string_view spelling, std::string_view name, std::optional<double> maximum) {
  const auto* row = find(spelling);
  if (row == nullptr) row = find(base::trimmed(spelling));
  if (row == nullptr) return {base::trimmed(spelling), 1, 1, 0, false};
  if (const auto field = calendar_field(*row, name, maximum)) return *field;
  if (row->spelling == "m" && is_minutes(name)) return {"s", 60};
  if (row->code == "Cel" && is_temperature_difference(name)) return {"K", row->multiply, row->divide};
  return {row->code, row->multiply, row->divide, row->shift};
}

}  // namespace rubicon::networks::zigbee::exposes
