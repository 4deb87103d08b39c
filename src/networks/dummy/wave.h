#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/config_reader.h"
#include "model/type_catalogue.h"

namespace rubicon::networks::dummy {

/// A random generator that gives the same numbers for the same seed on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// In [0, 1).
  double next();

 private:
  std::uint64_t state_;
};

/// Combines a seed with a text, so that each point has a seed of its own.
std::uint64_t seed_of(std::uint64_t seed, std::string_view text);

/// The values of a simulated sensor over time: a shape between two levels, with noise, within the range of its type.
/// Many sensors may share one; each has its own chance.
class Wave {
 public:
  struct Chance {
    explicit Chance(std::uint64_t seed) : random(seed) {}
    Random random;
    double position = 0.5;  ///< of a random walk, from 0 to 1
  };

  /// Reads wave, low, high, period, noise, value and values; mistakes are added to the errors of `options`.
  static Wave read(ConfigReader& options, const Type& type);

  /// The value at the time `since` the first opening of the network. Noise and random walks change with each call.
  Value at(Duration since, Chance& chance) const;
  /// The value at the upper or lower level, which a sensor has that follows a switched actuator.
  Value level(bool high) const;
  /// A number as a value of the type: clamped and rounded; a boolean is true in the upper half.
  Value value_of(double number) const;

 private:
  enum class Shape { kConstant, kSine, kSquare, kSawtooth, kRandom, kSteps };

  explicit Wave(const Type& type) : type_(&type) {}
  void read_levels(ConfigReader& options);
  void read_steps(ConfigReader& options);
  double number_at(Duration since, Chance& chance) const;

  const Type* type_;
  Shape shape_ = Shape::kConstant;
  double low_ = 0, high_ = 1, noise_ = 0;
  Duration period_{};
  int decimals_ = 2;
  std::vector<Value> steps_;  ///< the values of steps, or the value of a constant
};

}  // namespace rubicon::networks::dummy
