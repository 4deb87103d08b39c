#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/point.h"
#include "motes/mote_records.h"

namespace rubicon::motes {

/// What a mote is built of. The first three are telosb motes with their sensor boards (wsn.md 11).
enum class Board { kStandard, kEm1000, kSe1000, kIris, kMicaz };
/// `STANDARD`, `EM1000`, ...
std::string_view to_string(Board board);
std::optional<Board> parse_board(std::string_view name);

/// kBoth: the counts stand beside the values, as sensors of their own.
enum class Units { kPhysical, kRaw, kBoth };
/// `physical`, `raw`, `both`.
std::optional<Units> parse_units(std::string_view name);

/// How counts become values on one network.
struct Calibration {
  Board board = Board::kStandard;
  Units units = Units::kPhysical;
  double temperature_at_zero = -39.6;  ///< d1 of the SHT11, depends on the supply voltage
  std::uint16_t threshold = 2048;      ///< counts from which PIR and magnetic sensors say on
};

/// One sensor of a mote: the catalogue's type name, the instance, and the transducer and word it is read from.
struct MoteSensor {
  std::string_view type;
  std::string instance;
  std::uint16_t transducer = 0;
  std::size_t word = 0;
  bool raw = false;  ///< the count itself
};

/// The sensors behind one transducer, in the order of its words; none for an id nobody defined.
std::vector<MoteSensor> sensors_of(std::uint16_t transducer, const Calibration& calibration);

/// The sensors a declared mask stands for. Unknown bits are ignored and 6F52, which was built by adding instead of
/// or-ing, is read as what was meant (wsn.md 6).
std::vector<MoteSensor> sensors_in_mask(std::uint16_t mask, const Calibration& calibration);

/// A count as a value in the unit of its sensor's type, or nothing where the count says "no reading". `celsius` is the
/// mote's latest temperature, which corrects humidity; without one 25 degrees are assumed.
std::optional<model::Value> convert(const MoteSensor& sensor, std::uint16_t count, const Calibration& calibration,
                                    std::optional<double> celsius);

/// Temperature in degrees for a count, for the board; nothing where the thermistor is open or shorted.
std::optional<double> temperature_of(std::uint16_t count, const Calibration& calibration);

}  // namespace rubicon::motes
