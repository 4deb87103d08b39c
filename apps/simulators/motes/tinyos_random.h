#pragma once

#include <cstdint>

namespace rubicon::motes_simulator {

/// The random numbers of TinyOS (RandomMlcgP: Park and Miller's generator, seeded with the node id + 1). The sequence
/// numbers of motes 2 and 3 and of sink 1 in the recordings come from it (247f is number 3 of mote 2); the numbers
/// between them are the radio's back-offs. That is why they repeat after each reboot (wsn.md 9.2).
class TinyosRandom {
 public:
  explicit TinyosRandom(std::uint16_t node) : seed_(node + 1U) {}

  std::uint16_t next() {
    const std::uint64_t product = std::uint64_t{33614} * seed_;
    const auto low = static_cast<std::uint32_t>(product) >> 1U;
    std::uint32_t sum = low + static_cast<std::uint32_t>(product >> 32U);
    if ((sum & 0x80000000U) != 0) sum = (sum & 0x7fffffffU) + 1;
    seed_ = sum;
    return static_cast<std::uint16_t>(seed_);
  }

 private:
  std::uint32_t seed_;
};

}  // namespace rubicon::motes_simulator
