#include "model/home_assistant.h"

#include <algorithm>
#include <utility>

#include "model/type_catalogue.h"

namespace rubicon::model {

namespace {

constexpr std::string_view kNoUnit = "-", kTotal = "total", kRising = "total_increasing", kMeasured = "measurement";

// type, device class, unit, state class, diagnostic, factor
constexpr EntityClass kEntityClasses[] = {
    {"temperature", "temperature", ""},
    {"dewPoint", "temperature", ""},
    {"temperatureSetpoint", "temperature", ""},
    {"minimumTemperatureSetpoint", "temperature", ""},
    {"maximumTemperatureSetpoint", "temperature", ""},
    {"absoluteTemperature", "temperature", ""},
    {"deviceTemperature", "temperature", "", kMeasured, true},
    {"temperatureDifference", "temperature_delta", ""},
    {"temperatureShift", "temperature_delta", ""},
    {"temperatureCalibration", "temperature_delta", ""},
    {"temperatureDeadBand", "temperature_delta", ""},
    {"humidity", "humidity", ""},
    {"humiditySetpoint", "humidity", ""},
    {"soilMoisture", "moisture", ""},
    {"absoluteHumidity", "absolute_humidity", ""},
    {"light", "illuminance", ""},
    {"illuminance", "illuminance", ""},
    {"solarIrradiance", "irradiance", ""},
    {"ultravioletIndex", "", "UV index"},
    {"co2", "carbon_dioxide", ""},
    {"carbonMonoxide", "carbon_monoxide", ""},
    {"voc", "volatile_organic_compounds_parts", ""},
    {"vocIndex", "aqi", kNoUnit},
    {"pm1", "pm1", ""},
    {"pm25", "pm25", ""},
    {"pm10", "pm10", ""},
    {"airPressure", "atmospheric_pressure", "hPa", kMeasured, false, 0.01},
    {"pressure", "pressure", ""},
    {"windSpeed", "wind_speed", ""},
    {"speed", "speed", ""},
    {"windDirection", "wind_direction", "", "measurement_angle"},
    {"rainRate", "precipitation_intensity", ""},
    {"rainAmount", "precipitation", "mm", kTotal},
    {"power", "power", ""},
    {"apparentPower", "apparent_power", ""},
    {"reactivePower", "reactive_power", ""},
    {"powerFactor", "power_factor", kNoUnit},
    {"energy", "energy", "", kTotal},
    {"energyProduced", "energy", "", kTotal},
    {"heatMeter", "energy", "", kRising},
    {"reactiveEnergy", "reactive_energy", "", kTotal},
    {"voltage", "voltage", ""},
    {"current", "current", ""},
    {"frequency", "frequency", ""},
    {"waterMeter", "water", "", kRising},
    {"gasMeter", "gas", "", kRising},
    {"volumeFlow", "volume_flow_rate", ""},
    {"volumeContent", "volume_storage", ""},
    {"mass", "weight", ""},
    {"bodyWeight", "weight", ""},
    {"distance", "distance", ""},
    {"length", "distance", ""},
    {"area", "area", ""},
    {"duration", "duration", ""},
    {"remainingTime", "duration", ""},
    {"operatingHours", "duration", "", kRising},
    {"durationMilliseconds", "duration", ""},
    {"interval", "duration", ""},
    {"holdTime", "duration", ""},
    {"transitionTime", "duration", ""},
    {"rssi", "signal_strength", "", kMeasured, true},
    {"signalPower", "signal_strength", "", kMeasured, true},
    {"txPower", "signal_strength", "", kMeasured, true},
    {"soundLevel", "sound_pressure", ""},
    {"conductivity", "conductivity", ""},
    {"acidity", "ph", kNoUnit},
    {"battery", "battery", "", kMeasured, true},
    {"linkQuality", "", "lqi", kMeasured, true},
    {"status", "", kNoUnit, kMeasured, true},
    {"counter", "", kNoUnit, kTotal},
    {"pulseCount", "", kNoUnit, kRising},
    {"powerOutageCount", "", kNoUnit, kRising, true},
};

// type, device class, diagnostic, first word is on
constexpr BinaryClass kBinaryClasses[] = {
    {"contact", "opening"},
    {"openWindow", "window"},
    {"openClose", "opening", false, true},
    {"motion", "motion"},
    {"pir", "motion"},
    {"occupancy", "occupancy"},
    {"seat", "occupancy"},
    {"pressureMat", "occupancy"},
    {"presence", "presence"},
    {"smoke", "smoke"},
    {"gas", "gas"},
    {"carbonMonoxideAlarm", "carbon_monoxide"},
    {"waterLeak", "moisture"},
    {"rain", "moisture"},
    {"vibration", "vibration"},
    {"tamper", "tamper", true},
    {"glassBreak", "safety"},
    {"alarm", "problem"},
    {"windAlarm", "problem"},
    {"frostAlarm", "problem"},
    {"fault", "problem", true},
    {"sabotageLine", "tamper", true},
    {"mainsPresent", "power", true},
    {"charger", "battery_charging", true},
    {"batteryLow", "battery", true},
    {"lock", "lock", false, true},  // their on = unlocked
    {"startStop", "running"},
    {"pump", "running"},
    {"heating", "heat"},
    {"cooling", "cold"},
};

/// Texts without a zone are those of the building, as Home Assistant's own.
constexpr std::string_view kFromClock =
    "{{ ((value_json.dateTime if value_json is defined and value_json is mapping else value) | as_datetime | "
    "as_local).isoformat() }}";
constexpr std::string_view kToClock = "{{ (value | as_datetime | as_local).strftime('%Y-%m-%dT%H:%M:%S') }}";

// type, platform, device class, templates
constexpr TextClass kTextClasses[] = {
    {"date", "date", "date", "", ""},
    {"timeOfDay", "time", "", "{{ value.split(' ')[-1] }}", ""},  // without the day of the week
    {"dateTime", "datetime", "timestamp", kFromClock, kToClock},
};

// platform, role, type; of several types of a role the first one that the device has
constexpr EntityPart kEntityParts[] = {
    {"climate", "preset", "preset"},     {"climate", "preset", "hvacMode"},       {"climate", "fan", "fanMode"},
    {"siren", "tone", "melody"},         {"siren", "duration", "siren_duration"}, {"siren", "duration", "duration"},
    {"siren", "volume_level", "volume"},
};

/// UCUM, theirs. The first of two that are the same to us is the one that we write.
constexpr std::pair<std::string_view, std::string_view> kHomeAssistantUnits[] = {
    {"1", ""},          {"Cel", "°C"},      {"[ppm]", "ppm"},   {"ug/m3", "μg/m³"}, {"mg/m3", "mg/m³"},
    {"g/m3", "g/m³"},   {"W/m2", "W/m²"},   {"V.A", "VA"},      {"kW.h", "kWh"},    {"kvar.h", "kvarh"},
    {"dB[mW]", "dBm"},  {"deg", "°"},       {"m3", "m³"},       {"m3/h", "m³/h"},   {"m2", "m²"},
    {"L/m2", "mm"},     {"uS/cm", "μS/cm"}, {"[pH]", ""},       {"/min", "1/min"},  {"Ohm", "Ω"},
    {"m/s2", "m/s²"},   {"cd/m2", "cd/m²"}, {"Bq/m3", "Bq/m³"}, {"kg/m3", "kg/m³"}, {"/cm3", "1/cm³"},
    {"mm[Hg]", "mmHg"}, {"kV.A.h", "kVAh"},
};

/// U+00B5, the micro sign, as older versions write it, becomes U+03BC.
std::string with_mu(std::string_view unit) {
  constexpr std::string_view kMicro = "\xc2\xb5", kMu = "\xce\xbc";
  std::string text(unit);
  for (auto at = text.find(kMicro); at != text.npos; at = text.find(kMicro)) text.replace(at, kMicro.size(), kMu);
  return text;
}

template <class Row>
const Row* row_of(std::span<const Row> rows, std::string_view type) {
  const auto found = std::find_if(rows.begin(), rows.end(), [type](const Row& row) { return row.type == type; });
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace

std::span<const EntityClass> entity_classes() {
  return kEntityClasses;
}

const EntityClass* entity_class_of(std::string_view type) {
  return row_of(entity_classes(), type);
}

const EntityClass* entity_class_by(std::string_view device_class, std::string_view unit) {
  static const TypeCatalogue types;
  const auto wanted = with_mu(unit);
  const auto* const found =
      std::find_if(std::begin(kEntityClasses), std::end(kEntityClasses), [&](const EntityClass& row) {
        const auto* type = types.find(row.type);
        const auto theirs = row.unit == kNoUnit ? std::string()
                            : !row.unit.empty() ? std::string(row.unit)
                            : type              ? to_entity_unit(type->unit)
                                                : std::string();
        return !device_class.empty() && row.device_class == device_class && theirs == wanted;
      });
  return found == std::end(kEntityClasses) ? nullptr : found;
}

std::span<const BinaryClass> binary_classes() {
  return kBinaryClasses;
}

const BinaryClass* binary_class_of(std::string_view type) {
  return row_of(binary_classes(), type);
}

const BinaryClass* binary_class_by(std::string_view device_class) {
  const auto* const found = std::find_if(std::begin(kBinaryClasses), std::end(kBinaryClasses), [&](const auto& row) {
    return !device_class.empty() && row.device_class == device_class;
  });
  return found == std::end(kBinaryClasses) ? nullptr : found;
}

std::span<const TextClass> text_classes() {
  return kTextClasses;
}

const TextClass* text_class_of(std::string_view type) {
  return row_of(text_classes(), type);
}

std::span<const EntityPart> entity_parts() {
  return kEntityParts;
}

std::string to_entity_unit(std::string_view ucum) {
  for (const auto& [ours, theirs] : kHomeAssistantUnits) {
    if (ours == ucum) return std::string(theirs);
  }
  return std::string(ucum);
}

std::string from_entity_unit(std::string_view unit) {
  const auto wanted = with_mu(unit);
  for (const auto& [ours, theirs] : kHomeAssistantUnits) {
    if (theirs == wanted) return std::string(ours);
  }
  return wanted;
}

}  // namespace rubicon::model
