#pragma once

#include <cstdint>
#include <random>

#include "rubicon/time.hpp"

namespace rubicon::networks::knx::line {

/// How long a routing client stops sending after ROUTING_BUSY, so that all clients stop and do not resume at the same
/// time (KNX 3/8/5; knx.md, section 7). N grows with each ROUTING_BUSY that comes more than 10 ms after the last.
class BusyRule {
 public:
  /// Bound of N, which bounds the random part of a pause to 5 s.
  static constexpr unsigned kMaxLevel = 100;

  explicit BusyRule(std::uint64_t seed) : random_(seed) {}

  /// A ROUTING_BUSY with this wait time.
  void receive(SteadyTime now, Duration wait);
  /// Nothing is sent before this time.
  SteadyTime resume_at() const { return resume_at_; }
  /// After the pause, telegrams are sent more slowly for N * 100 ms.
  bool slow(SteadyTime now) const { return n_ > 0 && now < slow_until(); }
  /// N: constant during the slow phase, then one less every 5 ms.
  unsigned level(SteadyTime now) const;

 private:
  SteadyTime slow_until() const;

  std::mt19937_64 random_;
  unsigned n_ = 0;
  SteadyTime counted_{}, resume_at_ = SteadyTime::min();
};

}  // namespace rubicon::networks::knx::line
