#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/point.h"
#include "motes/mote_records.h"

namespace rubicon::motes {

/// Hardware of a mote. The first three are telosb motes with their sensor boards (wsn.md 11).
enum class Board { kStandard, kEm1000, kSe1000, kIris, kMicaz };
/// `STANDARD`, `EM1000`, ...
std::string_view to_string(Board board);
std::optional<Board> parse_board(std::string_view name);

/// kBoth: counts in addition to the values, as separate sensors.
enum class Units { kPhysical, kRaw, kBoth };
/// `physical`, `raw`, `both`.
std::optional<Units> parse_units(std::string_view name);

/// How counts are converted to values on one network.
struct Calibration {
  Board board = Board::kStandard;
  Units units = Units::kPhysical;
  double temperature_at_zero = -39.6;  ///< d1 of the SHT11, depends on the supply voltage
  std::uint16_t threshold = 2048;      ///< counts from which PIR and magnetic sensors are on
};

/// One sensor of a mote: the catalogue's type name, the instance, and the transducer and word it comes from.
struct MoteSensor {
  std::string_view type;
  std::string instance;
  std::uint16_t transducer = 0;
  std::size_t word = 0;
  bool raw = false;  ///< the count itself
};

/// The sensors of one transducer, in the order of its words; none for undefined ids.
std::vector<MoteSensor> sensors_of(std::uint16_t transducer, const Calibration& calibration);

/// The sensors of a declared mask. Unknown bits are ignored; 6F52, which the firmware computes by adding instead of
/// or-ing, is replaced by the intended mask (wsn.md 6).
std::vector<MoteSensor> sensors_in_mask(std::uint16_t mask, const Calibration& calibration);

/// A count as a value in the unit of its sensor's type; nullopt if the count means "no reading". `celsius` is the
/// mote's latest temperature, which corrects humidity; 25 degrees if unknown.
std::optional<model::Value> convert(const MoteSensor& sensor, std::uint16_t count, const Calibration& calibration,
                                    std::optional<double> celsius);

/// Temperature of a count in degrees Celsius, by the board; nullopt if the thermistor is open or shorted.
std::optional<double> temperature_of(std::uint16_t count, const Calibration& calibration);

}  // namespace rubicon::motes
