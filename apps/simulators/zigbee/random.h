#pragma once

#include <array>
#include <cstdint>
#include <random>

namespace rubicon::zigbee_simulator {

/// Random numbers that are the same for the same seed on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// 0 to `below` - 1; 0 if `below` is 0.
  std::uint64_t below(std::uint64_t below) { return below == 0 ? 0 : engine_() % below; }
  /// `low` to `high`, both included.
  std::int64_t between(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(below(static_cast<std::uint64_t>(high - low) + 1));
  }
  /// 0 to 1.
  double share() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// True so many times in a thousand.
  bool chance(std::uint64_t per_mille) { return below(1000) < per_mille; }

  template <class List>
  const auto& one_of(const List& list) {
    return list[below(list.size())];
  }
  /// The index of a weight, as often as the weight says.
  template <std::size_t Count>
  std::size_t weighted(const std::array<int, Count>& weights) {
    int sum = 0;
    for (const int weight : weights) sum += weight;
    auto drawn = between(1, sum);
    std::size_t index = 0;
    while ((drawn -= weights[index]) > 0) ++index;
    return index;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace rubicon::zigbee_simulator
