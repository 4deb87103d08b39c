#include "networks/zigbee/exposes/type_table.h"

#include <algorithm>
#include <vector>

namespace rubicon::networks::zigbee::exposes {

namespace {

using enum LeafForm;
using enum Use;
using enum Scale;

constexpr std::string_view kHvacWords = "auto=auto,heat=heat,cool=cool,off=off,fan=fan_only,dry=dry";
constexpr std::string_view kSwitchWords = "on=ON,off=OFF";
constexpr std::string_view kLockWords = "on=LOCK|LOCKED,off=UNLOCK|UNLOCKED";
constexpr std::string_view kOpenWords = "on=OPEN|OPENED,off=CLOSE|CLOSED";
/// A made contact is a closed door: true, whichever of the two is value_on.
constexpr std::string_view kContactWords = "on=FALSE|OFF|OPEN|CONTACT_OPEN,off=TRUE|ON|CLOSED|CONTACT_CLOSED";

// The types that ZigBee devices become. A row is chosen by group, name, form, unit and use of the leaf; the first that
// fits counts. docs/zigbee.md explains it by examples. Special meanings come first, whole families by unit last.
//
// group, name, form, unit, use, type, instance, scale, words
constexpr TypeRow kRows[] = {
    // Lamps
    {"light", "state", kBinary, "", kAny, "lamp", ""},
    {"light", "brightness", kNumeric, "", kAny, "dimmer", "", kShare},
    {"light", "brightness", kNumeric, "%", kAny, "dimmer", ""},
    {"light", "color_temp", kNumeric, "mired", kAny, "colourTemperatureMired", ""},
    {"light", "color_temp", kNumeric, "K", kAny, "colourTemperature", ""},
    {"light", "color_temp_startup", kNumeric, "mired", kAny, "powerOnColourTemperatureMired", ""},
    {"light", "color_xy", kComposite, "", kAny, "colourXy", ""},
    {"light", "color_hs", kComposite, "", kAny, "colourHueSaturation", ""},
    {"", "brightness", kNumeric, "", kAny, "dimmer", "", kShare},
    {"", "brightness", kNumeric, "%", kAny, "dimmer", ""},
    {"*", "min_brightness", kNumeric, "", kSet, "minimumLevel", ""},
    {"*", "max_brightness", kNumeric, "", kSet, "maximumLevel", ""},
    {"", "min_level", kNumeric, "", kSet, "minimumLevel", "level"},
    {"", "max_level", kNumeric, "", kSet, "maximumLevel", "level"},
    {"", "ballast_minimum_level", kNumeric, "", kSet, "minimumLevel", "ballast"},
    {"", "ballast_maximum_level", kNumeric, "", kSet, "maximumLevel", "ballast"},
    {"", "effect", kEnum, "", kAny, "effect", ""},
    {"", "effect_speed", kNumeric, "", kAny, "effectSpeed", "", kFraction},
    {"", "effect_color", kText, "", kAny, "effectColour", ""},
    {"*", "transition", kNumeric, "s", kAny, "transitionTime", ""},
    {"", "do_not_disturb", kBinary, "", kAny, "doNotDisturb", ""},

    // Switches and sockets
    {"switch", "state", kBinary, "", kAny, "switch", "", kSame, kSwitchWords},
    {"", "state", kBinary, "", kSet, "switch", "", kSame, kSwitchWords},
    {"", "switch", kBinary, "", kSet, "switch", "switch"},
    {"", "power_on_behavior", kEnum, "", kAny, "powerOnBehaviour", "", kSame,
     "off=off|OFF,on=on|ON,previous=previous|restore,toggle=toggle|inverted|reverse"},
    {"", "power_outage_memory", kEnum, "", kAny, "powerOnBehaviour", "outage", kSame, "off=off,on=on,previous=restore"},
    {"", "power_outage_memory", kBinary, "", kAny, "powerOutageMemory", ""},
    {"", "power_outage_count", kNumeric, "", kRead, "powerOutageCount", ""},
    {"", "countdown", kNumeric, "s", kAny, "remainingTime", ""},
    {"", "countdown_*", kNumeric, "s", kAny, "remainingTime", ""},
    {"", "switch_type", kEnum, "", kAny, "switchType", ""},
    {"", "switch_type_*", kEnum, "", kAny, "switchType", ""},
    {"", "operation_mode", kEnum, "", kAny, "deviceMode", ""},
    {"", "indicator_mode", kEnum, "", kAny, "indicatorMode", ""},
    {"", "backlight_mode", kEnum, "", kAny, "backlightMode", ""},
    {"", "backlight_mode", kBinary, "", kSet, "ledIndication", "backlight"},
    {"", "led_indicator", kBinary, "", kSet, "ledIndication", ""},
    {"", "led_indication", kBinary, "", kSet, "ledIndication", "indication"},
    {"", "led_enable", kBinary, "", kSet, "ledIndication", "enable"},
    {"", "indicator", kBinary, "", kSet, "ledIndication", "indicator"},

    // Covers and locks
    {"cover", "position", kNumeric, "%", kAny, "blindPosition", "", kClosed},
    {"cover", "tilt", kNumeric, "%", kAny, "blindTilt", "", kClosed},
    {"cover", "state", kEnum, "", kAny, "blindMove", "", kSame, "up=OPEN,down=CLOSE,stop=STOP"},
    {"", "state", kEnum, "", kAny, "blindMove", "", kSame, "up=OPEN|open,down=CLOSE|close,stop=STOP|stop"},
    {"*", "motor_state", kEnum, "", kAny, "motorState", ""},
    {"", "moving", kEnum, "", kRead, "motorState", "moving"},
    {"lock", "state", kBinary, "", kAny, "lock", "", kSame, kLockWords},
    {"lock", "lock_state", kEnum, "", kAny, "lockState", "", kSame,
     "unlocked=unlocked,locked=locked,not-fully-locked=not_fully_locked"},
    {"*", "child_lock", kBinary, "", kAny, "childLock", "", kSame, kLockWords},
    {"", "keypad_lockout", kEnum, "", kAny, "keypadLockout", ""},
    {"", "auto_lock", kBinary, "", kAny, "autoLock", ""},

    // Heating and air
    {"climate", "local_temperature", kNumeric, "Cel", kAny, "temperature", "local"},
    {"climate", "occupied_heating_setpoint", kNumeric, "Cel", kAny, "temperatureSetpoint", ""},
    {"climate", "current_heating_setpoint", kNumeric, "Cel", kAny, "temperatureSetpoint", ""},
    {"climate", "unoccupied_heating_setpoint", kNumeric, "Cel", kAny, "temperatureSetpoint", "unoccupied"},
    {"climate", "occupied_cooling_setpoint", kNumeric, "Cel", kAny, "temperatureSetpoint", "cooling"},
    {"climate", "unoccupied_cooling_setpoint", kNumeric, "Cel", kAny, "temperatureSetpoint", "unoccupied-cooling"},
    {"", "target_temperature", kNumeric, "Cel", kSet, "temperatureSetpoint", "target"},
    {"", "eco_temperature", kNumeric, "Cel", kSet, "temperatureSetpoint", "eco"},
    {"", "comfort_temperature", kNumeric, "Cel", kSet, "temperatureSetpoint", "comfort"},
    {"", "holiday_temperature", kNumeric, "Cel", kSet, "temperatureSetpoint", "holiday"},
    {"*", "system_mode", kEnum, "", kAny, "hvacController", "", kSame, kHvacWords},
    {"*", "system_mode", kEnum, "", kAny, "thermostatMode", ""},
    {"", "mode", kEnum, "", kSet, "hvacController", "mode", kSame, kHvacWords},
    {"climate", "running_mode", kEnum, "", kAny, "hvacController", "running", kSame, kHvacWords},
    {"*", "running_state", kEnum, "", kAny, "hvacState", "", kSame, "idle=idle,heat=heat,cool=cool,fan=fan_only"},
    {"climate", "preset", kEnum, "", kAny, "preset", ""},
    {"climate", "fan_mode", kEnum, "", kAny, "fanMode", ""},
    {"*", "pi_heating_demand", kNumeric, "%", kAny, "heatingDemand", ""},
    {"climate", "position", kNumeric, "%", kAny, "valve", ""},
    {"", "valve_position", kNumeric, "%", kAny, "valve", ""},
    {"", "valve_position", kNumeric, "", kAny, "valve", "", kShare},
    {"", "valve_opening_degree", kNumeric, "%", kAny, "valve", "opening"},
    {"climate", "pi_cooling_demand", kNumeric, "%", kAny, "coolingDemand", ""},
    {"climate", "local_temperature_calibration", kNumeric, "K", kAny, "temperatureCalibration", "temperature-local"},
    {"", "local_temperature_calibration", kNumeric, "K", kAny, "temperatureCalibration", "temperature-local"},
    {"", "temperature_calibration", kNumeric, "K", kAny, "temperatureCalibration", ""},
    {"", "temperature_offset", kNumeric, "K", kAny, "temperatureCalibration", "offset"},
    {"", "temperature_offset", kNumeric, "", kSet, "temperatureCalibration", "offset"},
    {"", "temperature_calibration", kNumeric, "", kSet, "temperatureCalibration", ""},
    {"", "humidity_calibration", kNumeric, "%", kAny, "humidityCalibration", ""},
    {"", "humidity_offset", kNumeric, "%", kAny, "humidityCalibration", "offset"},
    {"*", "max_heat_setpoint_limit", kNumeric, "Cel", kAny, "maximumTemperatureSetpoint", ""},
    {"*", "min_heat_setpoint_limit", kNumeric, "Cel", kAny, "minimumTemperatureSetpoint", ""},
    {"*", "max_cool_setpoint_limit", kNumeric, "Cel", kAny, "maximumTemperatureSetpoint",
     "temperatureSetpoint-cooling"},
    {"*", "min_cool_setpoint_limit", kNumeric, "Cel", kAny, "minimumTemperatureSetpoint",
     "temperatureSetpoint-cooling"},
    {"*", "abs_max_heat_setpoint_limit", kNumeric, "Cel", kAny, "maximumTemperatureSetpoint", "absolute"},
    {"*", "abs_min_heat_setpoint_limit", kNumeric, "Cel", kAny, "minimumTemperatureSetpoint", "absolute"},
    {"", "max_temperature_limit", kNumeric, "Cel", kSet, "maximumTemperatureSetpoint", "limit"},
    {"", "min_temperature_limit", kNumeric, "Cel", kSet, "minimumTemperatureSetpoint", "limit"},
    {"", "max_temperature", kNumeric, "Cel", kSet, "maximumTemperatureSetpoint", "temperature"},
    {"", "min_temperature", kNumeric, "Cel", kSet, "minimumTemperatureSetpoint", "temperature"},
    {"", "floor_max_setpoint", kNumeric, "Cel", kSet, "maximumTemperatureSetpoint", "floor"},
    {"", "floor_min_setpoint", kNumeric, "Cel", kSet, "minimumTemperatureSetpoint", "floor"},
    {"", "deadzone_temperature", kNumeric, "K", kSet, "temperatureDeadBand", ""},
    {"", "min_setpoint_deadband", kNumeric, "K", kSet, "temperatureDeadBand", "setpoint"},
    {"*", "window_detection", kBinary, "", kSet, "windowDetection", ""},
    {"*", "valve_detection", kBinary, "", kSet, "valveDetection", ""},
    {"*", "frost_protection", kBinary, "", kSet, "frostProtection", ""},
    {"*", "away_mode", kBinary, "", kSet, "awayMode", ""},
    {"", "boost_heating", kBinary, "", kSet, "boost", ""},
    {"", "boost", kBinary, "", kSet, "boost", "boost"},
    {"", "window_open", kBinary, "", kRead, "openWindow", "", kSame, kOpenWords},
    {"", "window", kBinary, "", kRead, "openWindow", "window", kSame, kOpenWords},
    {"", "temperature_display_mode", kEnum, "", kAny, "temperatureUnit", "", kSame,
     "celsius=celsius,fahrenheit=fahrenheit"},
    {"", "temperature_unit", kEnum, "", kAny, "temperatureUnit", "unit", kSame,
     "celsius=celsius,fahrenheit=fahrenheit"},
    {"", "temperature_unit_convert", kEnum, "", kAny, "temperatureUnit", "convert", kSame,
     "celsius=celsius,fahrenheit=fahrenheit"},
    {"*", "schedule_*", kText, "", kSet, "schedule", ""},
    {"fan", "state", kBinary, "", kAny, "fan", "", kSame, kSwitchWords},
    {"fan", "mode", kEnum, "", kAny, "fanMode", ""},
    {"fan", "speed", kNumeric, "", kAny, "fanSpeed", "", kShare},
    {"fan", "speed", kNumeric, "%", kAny, "fanSpeed", ""},
    {"", "fan_mode", kEnum, "", kAny, "fanMode", ""},
    {"", "fan_speed", kNumeric, "", kAny, "fanStage", ""},
    {"", "*_fan_speed", kNumeric, "", kAny, "fanStage", ""},
    {"", "fan_speed", kNumeric, "%", kAny, "fanSpeed", ""},
    {"", "fan_speed", kEnum, "", kAny, "fanMode", "speed"},

    // Detectors
    {"", "contact", kBinary, "", kRead, "contact", "", kSame, kContactWords},
    {"", "*_contact", kBinary, "", kRead, "contact", "", kSame, kContactWords},
    {"", "occupancy", kBinary, "", kRead, "motion", ""},
    {"", "motion", kBinary, "", kRead, "motion", "motion"},
    {"", "presence", kBinary, "", kRead, "presence", ""},
    {"", "motion_state", kEnum, "", kRead, "motionState", ""},
    {"", "presence_state", kEnum, "", kRead, "motionState", "presence"},
    {"", "vibration", kBinary, "", kRead, "vibration", ""},
    {"", "tamper", kBinary, "", kRead, "tamper", ""},
    {"", "smoke", kBinary, "", kRead, "smoke", ""},
    {"", "gas", kBinary, "", kRead, "gas", ""},
    {"", "carbon_monoxide", kBinary, "", kRead, "carbonMonoxideAlarm", ""},
    {"", "water_leak", kBinary, "", kRead, "waterLeak", ""},
    {"", "rain", kBinary, "", kRead, "rain", ""},
    {"", "alarm", kBinary, "", kRead, "alarm", ""},
    {"", "siren", kBinary, "", kSet, "siren", ""},
    {"", "alarm", kBinary, "", kSet, "siren", "alarm"},
    {"", "fault", kBinary, "", kRead, "fault", ""},
    {"", "sensitivity", kEnum, "", kAny, "sensitivity", "", kSame, "low=low,medium=medium|middle,high=high"},
    {"", "motion_sensitivity", kEnum, "", kAny, "sensitivity", "motion", kSame,
     "low=low,medium=medium|middle,high=high"},
    {"", "occupancy_timeout", kNumeric, "s", kAny, "holdTime", ""},
    {"", "fading_time", kNumeric, "s", kSet, "holdTime", "fading"},
    {"", "air_quality", kEnum, "", kRead, "airQuality", ""},
    {"", "melody", kEnum, "", kAny, "melody", ""},
    {"", "alarm_volume", kEnum, "", kAny, "alarmVolume", ""},
    {"", "volume", kEnum, "", kAny, "alarmVolume", "volume"},
    {"", "sound_volume", kEnum, "", kAny, "alarmVolume", "sound"},
    {"", "volume", kNumeric, "%", kAny, "volume", ""},
    {"", "volume", kNumeric, "", kAny, "volume", "", kShare},
    {"", "alarm_volume", kNumeric, "%", kAny, "volume", "alarm"},
    {"", "alarm_volume", kNumeric, "", kAny, "volume", "alarm", kShare},
    {"", "test", kBinary, "", kRead, "selfTest", ""},
    {"", "self_test", kBinary, "", kRead, "selfTest", "self_test"},
    {"", "reading_interval", kNumeric, "s", kSet, "interval", "reading"},
    {"", "measurement_interval", kNumeric, "s", kSet, "interval", "measurement"},
    {"", "sampling_interval", kNumeric, "s", kSet, "interval", "sampling"},
    {"", "*_report_interval", kNumeric, "s", kSet, "interval", ""},

    // Remote controls
    {"", "action", kEnum, "", kAny, "action", ""},
    {"", "identify", kEnum, "", kAny, "identify", ""},

    // The device itself
    {"", "battery", kNumeric, "%", kRead, "battery", ""},
    {"", "battery", kNumeric, "", kRead, "battery", ""},
    {"", "battery_low", kBinary, "", kRead, "batteryLow", ""},
    {"", "battery_state", kEnum, "", kRead, "batteryState", "", kSame, "low=low,medium=medium|middle,high=high"},
    {"", "linkquality", kNumeric, "{level}", kRead, "linkQuality", ""},
    {"", "linkquality", kNumeric, "", kRead, "linkQuality", ""},
    {"", "device_temperature", kNumeric, "Cel", kRead, "deviceTemperature", ""},
    {"", "serial_number", kText, "", kRead, "serialNumber", ""},

    // Measurements
    {"", "temperature", kNumeric, "Cel", kRead, "temperature", ""},
    {"", "temperature_*", kNumeric, "Cel", kRead, "temperature", ""},
    {"*", "*_temperature", kNumeric, "Cel", kRead, "temperature", ""},
    {"", "humidity", kNumeric, "%", kRead, "humidity", ""},
    {"", "*_humidity", kNumeric, "%", kRead, "humidity", ""},
    {"", "soil_moisture", kNumeric, "%", kRead, "soilMoisture", ""},
    {"", "illuminance", kNumeric, "lx", kRead, "light", ""},
    {"", "*_distance", kNumeric, "m", kRead, "distance", ""},
    {"", "distance", kNumeric, "m", kRead, "distance", ""},
    {"", "illuminance_*", kNumeric, "lx", kRead, "light", ""},
    {"", "illuminance", kNumeric, "{raw}", kRead, "lightRaw", ""},
    {"", "pressure", kNumeric, "Pa", kRead, "airPressure", ""},
    {"", "co2", kNumeric, "[ppm]", kRead, "co2", ""},
    {"", "co", kNumeric, "[ppm]", kRead, "carbonMonoxide", ""},
    {"", "voc", kNumeric, "[ppm]", kRead, "voc", ""},
    {"", "eco2", kNumeric, "[ppm]", kRead, "co2", "equivalent"},
    {"", "voc_index", kNumeric, "{index}", kRead, "vocIndex", ""},
    {"", "voc_index", kNumeric, "", kRead, "vocIndex", ""},
    {"", "formaldehyd", kNumeric, "ug/m3", kRead, "formaldehyde", ""},
    {"", "formaldehyde", kNumeric, "ug/m3", kRead, "formaldehyde", "formaldehyde"},
    {"", "hcho", kNumeric, "ug/m3", kRead, "formaldehyde", "hcho"},
    {"", "pm1", kNumeric, "ug/m3", kRead, "pm1", ""},
    {"", "pm25", kNumeric, "ug/m3", kRead, "pm25", ""},
    {"", "pm10", kNumeric, "ug/m3", kRead, "pm10", ""},
    {"", "gas_value", kNumeric, "%{LEL}", kRead, "gasLevel", ""},
    {"", "noise", kNumeric, "dB", kRead, "soundLevel", ""},
    {"", "wind_speed", kNumeric, "m/s", kRead, "windSpeed", ""},
    {"", "wind_direction", kNumeric, "deg", kRead, "windDirection", ""},
    {"", "uv_index", kNumeric, "", kRead, "ultravioletIndex", ""},

    // Electricity and meters
    {"", "power", kNumeric, "W", kRead, "power", ""},
    {"", "power_*", kNumeric, "W", kRead, "power", ""},
    {"", "*_power", kNumeric, "W", kRead, "power", ""},
    {"", "energy", kNumeric, "kW.h", kRead, "energy", ""},
    {"", "produced_energy", kNumeric, "kW.h", kRead, "energyProduced", ""},
    {"", "energy_produced", kNumeric, "kW.h", kRead, "energyProduced", "produced"},
    {"", "produced_energy_*", kNumeric, "kW.h", kRead, "energyProduced", ""},
    {"", "energy_produced_*", kNumeric, "kW.h", kRead, "energyProduced", ""},
    {"", "energy_*", kNumeric, "kW.h", kRead, "energy", ""},
    {"", "*_energy", kNumeric, "kW.h", kRead, "energy", ""},
    {"", "voltage", kNumeric, "V", kRead, "voltage", ""},
    {"", "voltage_*", kNumeric, "V", kRead, "voltage", ""},
    {"", "*_voltage", kNumeric, "V", kRead, "voltage", ""},
    {"", "current", kNumeric, "A", kRead, "current", ""},
    {"", "current_*", kNumeric, "A", kRead, "current", ""},
    {"", "*_current", kNumeric, "A", kRead, "current", ""},
    {"", "power_factor", kNumeric, "", kRead, "powerFactor", ""},
    {"", "power_factor", kNumeric, "%", kRead, "powerFactor", ""},
    {"", "power_factor_*", kNumeric, "", kRead, "powerFactor", ""},
    {"", "power_factor_*", kNumeric, "%", kRead, "powerFactor", ""},
    {"", "power_apparent", kNumeric, "V.A", kRead, "apparentPower", ""},
    {"", "power_apparent_*", kNumeric, "V.A", kRead, "apparentPower", ""},
    {"", "power_reactive", kNumeric, "var", kRead, "reactivePower", ""},
    {"", "power_reactive_*", kNumeric, "var", kRead, "reactivePower", ""},
    {"", "water_consumed", kNumeric, "m3", kRead, "waterMeter", ""},
    {"", "water_consumed_total", kNumeric, "m3", kRead, "waterMeter", "total"},
    {"", "water_total", kNumeric, "m3", kRead, "waterMeter", "total"},
    {"", "reverse_water_consumed", kNumeric, "m3", kRead, "waterMeter", "reverse"},
    {"*", "*_water_meter", kNumeric, "m3", kAny, "waterMeter", ""},
    {"", "gas", kNumeric, "m3", kRead, "gasMeter", ""},
    {"", "ac_frequency", kNumeric, "Hz", kRead, "frequency", ""},
    {"", "ac_frequency_*", kNumeric, "Hz", kRead, "frequency", ""},

    // What only reports, by its unit; the instance is the name of the leaf
    {"*", "*", kNumeric, "Cel", kRead, "temperature", ""},
    {"*", "*", kNumeric, "K", kRead, "temperatureDifference", ""},
    {"*", "*", kNumeric, "lx", kRead, "light", ""},
    {"*", "*", kNumeric, "Pa", kRead, "pressure", ""},
    {"*", "*", kNumeric, "Pa/h", kRead, "pressureTrend", ""},
    {"*", "*", kNumeric, "[ppm]", kRead, "concentration", ""},
    {"*", "*", kNumeric, "ug/m3", kRead, "massConcentration", ""},
    {"*", "*", kNumeric, "mg/L", kRead, "waterConcentration", ""},
    {"*", "*", kNumeric, "/cm3", kRead, "particleCount", ""},
    {"*", "*", kNumeric, "%{LEL}", kRead, "gasLevel", ""},
    {"*", "*", kNumeric, "dB", kRead, "levelRatio", ""},
    {"*", "*", kNumeric, "dB[mW]", kRead, "signalPower", ""},
    {"*", "*", kNumeric, "dB/m", kRead, "smokeDensity", ""},
    {"*", "*", kNumeric, "uR/h", kRead, "doseRate", ""},
    {"*", "*", kNumeric, "[pH]", kRead, "acidity", ""},
    {"*", "*", kNumeric, "uS/cm", kRead, "conductivity", ""},
    {"*", "*", kNumeric, "W", kRead, "power", ""},
    {"*", "*", kNumeric, "kW.h", kRead, "energy", ""},
    {"*", "*", kNumeric, "V.A", kRead, "apparentPower", ""},
    {"*", "*", kNumeric, "var", kRead, "reactivePower", ""},
    {"*", "*", kNumeric, "kvar.h", kRead, "reactiveEnergy", ""},
    {"*", "*", kNumeric, "V", kRead, "voltage", ""},
    {"*", "*", kNumeric, "A", kRead, "current", ""},
    {"*", "*", kNumeric, "Hz", kRead, "frequency", ""},
    {"*", "*", kNumeric, "s", kRead, "duration", ""},
    {"*", "*", kNumeric, "m", kRead, "length", ""},
    {"*", "*", kNumeric, "m/s", kRead, "speed", ""},
    {"*", "*", kNumeric, "mm/h", kRead, "rainRate", ""},
    {"*", "*", kNumeric, "m3", kRead, "volumeContent", ""},
    {"*", "*", kNumeric, "m3/h", kRead, "volumeFlow", ""},
    {"*", "*", kNumeric, "g", kRead, "mass", ""},
    {"*", "*", kNumeric, "deg", kRead, "angle", ""},
    {"*", "*", kNumeric, "/min", kRead, "rate1PerMinute", ""},
    {"*", "*", kNumeric, "%", kRead, "percentage", ""},
    {"*", "*", kNumeric, "{raw}", kRead, "analogueInput", ""},
    {"*", "*", kNumeric, "{level}", kRead, "deviceLevel", ""},
};

/// Whether the name fits the pattern of a row, and what its `*` stands for.
bool fits_name(std::string_view pattern, std::string_view name, std::string_view& matched) {
  const auto star = pattern.find('*');
  matched = {};
  if (star == pattern.npos) return pattern == name;
  const auto before = pattern.substr(0, star), after = pattern.substr(star + 1);
  if (name.size() <= before.size() + after.size() || !name.starts_with(before) || !name.ends_with(after)) return false;
  matched = name.substr(before.size(), name.size() - before.size() - after.size());
  return true;
}

bool fits_use(Use use, const LeafAccess& access) {
  return use == Use::kAny || (use == Use::kSet) == access.settable;
}

/// The next `word=one|other` of a row's words, which is taken off.
std::string_view take_entry(std::string_view& words) {
  const auto comma = words.find(',');
  const auto entry = words.substr(0, comma);
  words.remove_prefix(comma == words.npos ? words.size() : comma + 1);
  return entry;
}

bool has_word(std::string_view spellings, std::string_view word) {
  while (!spellings.empty()) {
    const auto bar = spellings.find('|');
    if (spellings.substr(0, bar) == word) return true;
    spellings.remove_prefix(bar == spellings.npos ? spellings.size() : bar + 1);
  }
  return false;
}

/// All words of the leaf are in the row, each for another word of the type.
bool fits_words(const TypeRow& row, const Leaf& leaf) {
  if (row.words.empty() || leaf.form != LeafForm::kEnum) return true;
  std::vector<std::string_view> words;
  for (const auto& value : leaf.values) {
    const auto word = type_word(row, value.name);
    if (word.empty() || std::find(words.begin(), words.end(), word) != words.end()) return false;
    words.push_back(word);
  }
  return !words.empty();
}

bool fits_scale(const TypeRow& row, const Leaf& leaf) {
  return row.scale != Scale::kShare || leaf.maximum.value_or(0) > 0;
}

}  // namespace

std::span<const TypeRow> type_rows() {
  return kRows;
}

const TypeRow* row_of(const Leaf& leaf, std::string_view group, std::string_view name, std::string_view code,
                      std::string_view& matched) {
  for (const auto& row : kRows) {
    if (row.form != leaf.form || (row.group != "*" && row.group != group) || row.unit != code) continue;
    if (!fits_use(row.use, leaf.access) || !fits_name(row.name, name, matched)) continue;
    if (fits_words(row, leaf) && fits_scale(row, leaf)) return &row;
  }
  return nullptr;
}

const TypeRow* row_of_type(std::string_view type) {
  const auto* found =
      std::find_if(std::begin(kRows), std::end(kRows), [&](const TypeRow& row) { return row.type == type; });
  return found == std::end(kRows) ? nullptr : found;
}

std::string_view leaf_word(const TypeRow& row, std::string_view word) {
  for (auto words = row.words; !words.empty();) {
    const auto entry = take_entry(words);
    const auto equals = entry.find('=');
    if (entry.substr(0, equals) == word) return entry.substr(equals + 1, entry.find('|') - equals - 1);
  }
  return {};
}

std::string_view type_word(const TypeRow& row, std::string_view word) {
  for (auto words = row.words; !words.empty();) {
    const auto entry = take_entry(words);
    const auto equals = entry.find('=');
    if (has_word(entry.substr(equals + 1), word)) return entry.substr(0, equals);
  }
  return {};
}

}  // namespace rubicon::networks::zigbee::exposes
