#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <string_view>

#include "rubicon/time.hpp"

namespace rubicon::motes_simulator {

/// A value that a mote can measure, by the original's name (wsn.md 6), and its position in Updates.
struct SensorPlace {
  std::string_view name;
  std::uint16_t transducer;
  std::size_t word;
};
inline constexpr std::array<SensorPlace, 15> kSensors{{{"light", 0x0001, 0},
                                                       {"temperature", 0x0002, 0},
                                                       {"accel_x_avg", 0x0004, 0},
                                                       {"accel_x_var", 0x0004, 1},
                                                       {"accel_y_avg", 0x0008, 0},
                                                       {"accel_y_var", 0x0008, 1},
                                                       {"pir", 0x0010, 0},
                                                       {"mic", 0x0020, 0},
                                                       {"humidity", 0x0040, 0},
                                                       {"magnetic", 0x0080, 0},
                                                       {"rssi1", 0x0100, 0},
                                                       {"rssi2", 0x0100, 1},
                                                       {"rssi3", 0x0100, 2},
                                                       {"rssi4", 0x0100, 3},
                                                       {"rssi5", 0x0100, 4}}};
inline constexpr std::size_t kLightSensor = 0;
inline constexpr std::size_t kTemperatureSensor = 1;

/// Index in kSensors.
std::optional<std::size_t> parse_sensor(std::string_view name);

/// The raw counts of a sensor over time.
struct Signal {
  enum class Shape : std::uint8_t {
    kCount,  ///< a fixed increment with each reading, as in the recordings: light 300 + 7n, temperature 6500 + n (m)
    kSet,    ///< always `to`
    kRamp,   ///< `from` to `to` in `span`, then `to`
    kSine,   ///< between `from` and `to`, one period in `span`
    kWalk    ///< random between `from` and `to`: steps of up to a twentieth of the range each `span`
  };
  Shape shape = Shape::kCount;
  double from = 0, to = 0;
  Duration span{};
  SteadyTime began{};
};

/// The sensors of one mote and the signals they measure.
class Sensors {
 public:
  explicit Sensors(std::uint64_t seed) : rng_(seed) {}

  void show(std::size_t sensor, const Signal& signal) { sensors_[sensor] = {signal, 0, std::nullopt, {}}; }
  std::uint16_t read(std::size_t sensor, SteadyTime now);
  /// Sets the state that it has after `readings` readings.
  void skip(std::size_t sensor, unsigned readings) { sensors_[sensor].readings += readings; }
  /// Restarts the counting signals, as a reboot of the mote does.
  void restart();

 private:
  struct One {
    Signal signal;
    std::uint64_t readings = 0;
    std::optional<double> at;  ///< of a walk
    SteadyTime walked{};
  };
  double walk(One& one, SteadyTime now);

  std::array<One, kSensors.size()> sensors_{};
  std::mt19937_64 rng_;
};

}  // namespace rubicon::motes_simulator
