#pragma once

#include <cstdint>
#include <deque>

#include "rubicon/time.hpp"

namespace rubicon::networks::knx::line {

/// How long to leave a server alone that refused a tunnel or took it away again (knx.md, sections 5.3 and 5.5). Losses
/// of other kinds are the affair of whoever reopens lines.
class HoldOff {
 public:
  explicit HoldOff(std::uint64_t seed) : random_(seed | 1) {}

  /// All tunnels are taken: 1, 2, 4 .. 60 s, each times 0.8 to 1.2.
  Duration slot_taken();
  /// Will not get better by itself: 60 s, then 300 s.
  Duration misconfigured();
  /// The server closed a tunnel that lived so long. Over 0: two clients seem to fight for it, wait.
  Duration closed_by_server(SteadyTime now, Duration lived);
  /// A tunnel ended that lived so long: after a minute the pauses are short again.
  void ended(Duration lived);
  /// A tunnel came about: what was wrong with the configuration is not any more.
  void connected() { misconfigured_before_ = false; }

 private:
  double jitter();

  std::uint64_t random_;
  Duration next_ = std::chrono::seconds(1);
  bool misconfigured_before_ = false;
  std::deque<SteadyTime> short_lives_;  ///< ends of the last tunnels that were closed young
};

}  // namespace rubicon::networks::knx::line
