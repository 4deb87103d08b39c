#include "motes/mote_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace rubicon::motes {

namespace {

constexpr std::string_view kBoardNames[] = {"STANDARD", "EM1000", "SE1000", "IRIS", "MICAZ"};
constexpr std::uint16_t kAddedMask = 0x6f52;
constexpr std::uint16_t kIntendedMask = 0x1f43;  // LIGHT, TEMP, HUMID, RSSI1..5
constexpr std::uint16_t kDefinedBits = 0x1fff;
constexpr std::uint16_t kUnset = 0xffff;
constexpr double kRoomTemperature = 25.0;
/// The firmware adds 50 to the register, which is 45 above dBm (wsn.md 11).
constexpr double kCc2420Offset = -95.0;

bool is_telosb(Board board) {
  return board != Board::kIris && board != Board::kMicaz;
}
bool has_cc2420(Board board) {
  return board != Board::kIris;
}

/// Sensor types of a transducer, for values and for raw counts.
struct Naming {
  Transducer transducer;
  std::string_view physical;
  std::string_view raw;
};

constexpr Naming kNamings[] = {
    {Transducer::kLight, "light", "lightRaw"},
    {Transducer::kTemperature, "temperature", "temperatureRaw"},
    {Transducer::kAccelerationX, "", "accelerationRaw"},
    {Transducer::kAccelerationY, "", "accelerationRaw"},
    {Transducer::kPir, "motion", "pirRaw"},
    {Transducer::kMicrophone, "microphone", "microphoneRaw"},
    {Transducer::kHumidity, "humidity", "humidityRaw"},
    {Transducer::kMagnetic, "magnetic", "magneticRaw"},
    {Transducer::kRssi1, "rssi", "rssiRaw"},
};
constexpr std::string_view kAccelerationSpread = "accelerationVarianceRaw";

const Naming* naming_of(Transducer transducer) {
  const auto* found = std::find_if(std::begin(kNamings), std::end(kNamings),
                                   [&](const Naming& naming) { return naming.transducer == transducer; });
  return found == std::end(kNamings) ? nullptr : found;
}

/// Whether the formula for this board is verified (wsn.md 11); otherwise the count itself is published.
bool has_formula(Transducer transducer, Board board) {
  switch (transducer) {
    case Transducer::kLight:
    case Transducer::kHumidity: return is_telosb(board);
    case Transducer::kRssi1: return has_cc2420(board);
    case Transducer::kMicrophone: return board == Board::kSe1000;
    case Transducer::kTemperature:
    case Transducer::kPir:
    case Transducer::kMagnetic: return true;
    default: return false;
  }
}

double rounded(double value, int decimals) {
  const double scale = std::pow(10.0, decimals);
  return std::round(value * scale) / scale;
}

double humidity_of(std::uint16_t count, double celsius) {
  const double raw = count;
  const double linear = -4.0 + 0.0405 * raw - 2.8e-6 * raw * raw;
  return std::clamp((celsius - kRoomTemperature) * (0.01 + 0.00008 * raw) + linear, 0.0, 100.0);
}

double lux_of(std::uint16_t count) {
  const double volts = count / 4096.0 * 1.5;
  const double amperes = volts / 100e3;
  return 0.625e6 * amperes * 1000.0;
}

/// The register has 8 bits and ends at 0 dBm: values far outside are no readings.
std::optional<model::Value> dbm_of(std::uint16_t count) {
  const double dbm = static_cast<std::int16_t>(count) + kCc2420Offset;
  if (dbm < -150 || dbm > 50) return std::nullopt;
  return dbm;
}

/// Steinhart-Hart equation of the MTS300's thermistor (wsn.md 11).
std::optional<double> thermistor(std::uint16_t count) {
  if (count == 0 || count >= 1023) return std::nullopt;
  const double raw = count;
  const double logarithm = std::log(10e3 * (1023.0 - raw) / raw);
  const double kelvin = 1.0 / (0.00130705 + 0.000214381 * logarithm + 0.000000093 * std::pow(logarithm, 3));
  return kelvin - 273.15;
}

/// The anchor of a transducer id: RSSI1..5 are bits, 6..10 are numbered (wsn.md 6).
std::size_t anchor_of(std::uint16_t transducer) {
  for (std::size_t anchor = 1; anchor <= 5; ++anchor) {
    if (transducer == 0x0080u << anchor) return anchor;
  }
  return transducer > 0x1000 && transducer <= 0x1005 ? transducer - 0x1000u + 5 : 0;
}

std::vector<MoteSensor> rssi_sensors(std::uint16_t transducer, std::string_view type, bool raw) {
  const std::size_t first = anchor_of(transducer);
  std::vector<MoteSensor> sensors;
  for (std::size_t word = 0; word < words_of(transducer); ++word)
    sensors.push_back({type, fmt::format("{}", first + word), transducer, word, raw});
  return sensors;
}

std::vector<MoteSensor> acceleration_sensors(std::uint16_t transducer, std::string_view type) {
  const std::string axis = transducer == static_cast<std::uint16_t>(Transducer::kAccelerationX) ? "x" : "y";
  return {{type, axis, transducer, 0, true}, {kAccelerationSpread, axis, transducer, 1, true}};
}

std::vector<MoteSensor> sensors_of(std::uint16_t transducer, std::string_view type, bool raw) {
  if (anchor_of(transducer) != 0) return rssi_sensors(transducer, type, raw);
  if (words_of(transducer) == 2) return acceleration_sensors(transducer, type);
  return {{type, "1", transducer, 0, raw}};
}

}  // namespace

std::optional<Units> parse_units(std::string_view name) {
  if (name == "physical") return Units::kPhysical;
  if (name == "raw") return Units::kRaw;
  if (name == "both") return Units::kBoth;
  return std::nullopt;
}

std::string_view to_string(Board board) {
  return kBoardNames[static_cast<std::size_t>(board)];
}

std::optional<Board> parse_board(std::string_view name) {
  const auto* found = std::find(std::begin(kBoardNames), std::end(kBoardNames), name);
  if (found == std::end(kBoardNames)) return std::nullopt;
  return static_cast<Board>(found - std::begin(kBoardNames));
}

std::vector<MoteSensor> sensors_of(std::uint16_t transducer, const Calibration& calibration) {
  const bool is_rssi = anchor_of(transducer) != 0;
  const Transducer known = is_rssi ? Transducer::kRssi1 : static_cast<Transducer>(transducer);
  const Naming* naming = naming_of(known);
  if (naming == nullptr) return {};
  const bool physical = calibration.units != Units::kRaw && has_formula(known, calibration.board);
  if (!physical) return sensors_of(transducer, naming->raw, true);
  auto sensors = sensors_of(transducer, naming->physical, false);
  if (calibration.units == Units::kBoth) {
    for (MoteSensor& counts : sensors_of(transducer, naming->raw, true)) sensors.push_back(std::move(counts));
  }
  return sensors;
}

std::vector<MoteSensor> sensors_in_mask(std::uint16_t mask, const Calibration& calibration) {
  if (mask == kAddedMask) mask = kIntendedMask;
  std::vector<MoteSensor> sensors;
  for (unsigned bit = 1; bit <= kDefinedBits; bit <<= 1) {
    if ((mask & bit) == 0) continue;
    for (MoteSensor& sensor : sensors_of(static_cast<std::uint16_t>(bit), calibration)) {
      const bool listed = std::any_of(sensors.begin(), sensors.end(), [&](const MoteSensor& other) {
        return other.type == sensor.type && other.instance == sensor.instance;
      });
      if (!listed) sensors.push_back(std::move(sensor));
    }
  }
  return sensors;
}

std::optional<double> temperature_of(std::uint16_t count, const Calibration& calibration) {
  if (is_telosb(calibration.board)) return calibration.temperature_at_zero + 0.01 * count;
  return thermistor(count);
}

std::optional<model::Value> convert(const MoteSensor& sensor, std::uint16_t count, const Calibration& calibration,
                                    std::optional<double> celsius) {
  const bool is_rssi = anchor_of(sensor.transducer) != 0;
  const Transducer transducer = is_rssi ? Transducer::kRssi1 : static_cast<Transducer>(sensor.transducer);
  if (is_rssi && count == kUnset) return std::nullopt;
  if (sensor.raw) return std::int64_t{count};
  switch (transducer) {
    case Transducer::kLight: return rounded(lux_of(count), 1);
    case Transducer::kHumidity: return rounded(humidity_of(count, celsius.value_or(kRoomTemperature)), 2);
    case Transducer::kMicrophone: return rounded(count / 4096.0 * 2.5, 3);
    case Transducer::kPir:
    case Transducer::kMagnetic: return count >= calibration.threshold;
    case Transducer::kRssi1: return dbm_of(count);
    default: break;
  }
  const std::optional<double> degrees = temperature_of(count, calibration);
  if (!degrees) return std::nullopt;
  return rounded(*degrees, 2);
}

}  // namespace rubicon::motes
