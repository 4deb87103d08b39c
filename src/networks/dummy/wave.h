#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/config_reader.h"
#include "model/type_catalogue.h"

namespace rubicon::networks::dummy {

/// Reproducible chance: the same seed gives the same numbers on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  /// From 0 up to, not including, 1.
  double roll();

 private:
  std::uint64_t state_;
};

/// A number that stays the same for a text, to give each point a seed of its own.
std::uint64_t seed_of(std::uint64_t seed, std::string_view text);

/// What a simulated sensor measures over time: a shape between two levels, with noise, in the terms of its type. Many
/// sensors may share one; what each has of its own is its chance.
class Wave {
 public:
  struct Chance {
    explicit Chance(std::uint64_t seed) : dice(seed) {}
    Dice dice;
    double position = 0.5;  ///< of a random walk, from 0 to 1
  };

  /// Reads wave, low, high, period, noise, value, values; what is wrong is reported to `options`.
  static Wave read(ConfigReader& options, const Type& type);

  /// The value `since` the network was opened first. Noise and walks go on with each call.
  Value at(Duration since, Chance& chance) const;
  /// What the wave gives at its lower or upper level: what a sensor shows that follows a switched actuator.
  Value level(bool high) const;
  /// A number in the terms of the type: clamped, rounded, a boolean from half way up.
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
  std::vector<Value> steps_;  ///< of steps, and the one value of a constant
};

}  // namespace rubicon::networks::dummy
