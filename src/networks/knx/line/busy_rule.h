#pragma once

#include <cstdint>
#include <random>

#include "rubicon/time.hpp"

namespace rubicon::networks::knx::line {

/// How long a sender of routing keeps silent when a router says ROUTING_BUSY, so that all senders stop and do not start
/// again at one time (KNX 3/8/5; knx.md, section 7). N grows by the busies that are said more than 10 ms apart.
class BusyRule {
 public:
  /// However many busies come: N stays below, and the random part of a pause at 5 s.
  static constexpr unsigned kMost = 100;

  explicit BusyRule(std::uint64_t seed) : random_(seed) {}

  void heard(SteadyTime now, Duration wait);
  /// Nothing is sent before.
  SteadyTime resume_at() const { return resume_at_; }
  /// After the pause, for N * 100 ms: routers get what waits slower.
  bool slow(SteadyTime now) const { return n_ > 0 && now < slow_until(); }
  /// N: kept during the slow phase, then one less each 5 ms.
  unsigned level(SteadyTime now) const;

 private:
  SteadyTime slow_until() const;

  std::mt19937_64 random_;
  unsigned n_ = 0;
  SteadyTime counted_{}, resume_at_ = SteadyTime::min();
};

}  // namespace rubicon::networks::knx::line
