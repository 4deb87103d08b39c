#include "apps/simulators/motes/sensors.h"

#include <algorithm>
#include <cmath>

namespace rubicon::motes_simulator {

namespace {

struct Steps {
  unsigned first, step;
};
/// The first three kinds as in the recordings (wsn.md, "What the emulated firmware is").
constexpr std::array<Steps, kSensors.size()> kSteps{{{300, 7},
                                                     {6500, 1},
                                                     {2048, 1},
                                                     {10, 0},
                                                     {2048, 2},
                                                     {12, 0},
                                                     {100, 11},
                                                     {1000, 5},
                                                     {1200, 3},
                                                     {500, 9},
                                                     {40, 0},
                                                     {45, 0},
                                                     {50, 0},
                                                     {55, 0},
                                                     {60, 0}}};

/// How often `span` has passed.
double share_of(const Signal& signal, SteadyTime now) {
  if (signal.span <= Duration{}) return 1;
  return static_cast<double>((now - signal.began).count()) / static_cast<double>(signal.span.count());
}

}  // namespace

std::optional<std::size_t> parse_sensor(std::string_view name) {
  const auto found =
      std::find_if(kSensors.begin(), kSensors.end(), [&](const auto& place) { return place.name == name; });
  if (found == kSensors.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kSensors.begin());
}

void Sensors::restart() {
  for (auto& one : sensors_) one.readings = 0;
}

double Sensors::walk(One& one, SteadyTime now) {
  const auto& signal = one.signal;
  if (!one.at) {
    one.at = (signal.from + signal.to) / 2;
    one.walked = now;
  }
  if (signal.span <= Duration{}) return *one.at;
  const auto steps = std::min<std::int64_t>((now - one.walked) / signal.span, 1000);
  if (steps > 0) one.walked = now;
  const double reach = std::abs(signal.to - signal.from) / 20;
  const auto [low, high] = std::minmax(signal.from, signal.to);
  for (std::int64_t i = 0; i < steps; ++i)
    one.at = std::clamp(*one.at + std::uniform_real_distribution<>(-reach, reach)(rng_), low, high);
  return *one.at;
}

std::uint16_t Sensors::read(std::size_t sensor, SteadyTime now) {
  constexpr double kTurn = 6.283185307179586;
  One& one = sensors_[sensor];
  const auto reading = one.readings++;
  const auto& signal = one.signal;
  double value = signal.to;
  switch (signal.shape) {
    case Signal::Shape::kCount: return static_cast<std::uint16_t>(kSteps[sensor].first + reading * kSteps[sensor].step);
    case Signal::Shape::kSet: break;
    case Signal::Shape::kRamp:
      value = signal.from + (signal.to - signal.from) * std::clamp(share_of(signal, now), 0.0, 1.0);
      break;
    case Signal::Shape::kSine:
      value = (signal.from + signal.to) / 2 + (signal.to - signal.from) / 2 * std::sin(kTurn * share_of(signal, now));
      break;
    case Signal::Shape::kWalk: value = walk(one, now); break;
  }
  return static_cast<std::uint16_t>(std::clamp(std::round(value), 0.0, 65535.0));
}

}  // namespace rubicon::motes_simulator
