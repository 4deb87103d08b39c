#pragma once

#include <cstdint>
#include <deque>

#include "rubicon/time.hpp"

namespace rubicon::networks::knx::line {

/// How long a tunnel line waits after a server refused a tunnel or closed one early (knx.md, sections 5.3 and 5.5).
/// Other losses are handled by the caller's reopen policy.
class HoldOff {
 public:
  explicit HoldOff(std::uint64_t seed) : random_(seed | 1) {}

  /// All tunnels are in use: 1, 2, 4 .. 60 s, each times 0.8 to 1.2.
  Duration slot_taken();
  /// The configuration must change: 60 s, then 300 s.
  Duration misconfigured();
  /// The server closed a tunnel of this age. Above 0: two clients probably compete for it, wait.
  Duration closed_by_server(SteadyTime now, Duration lived);
  /// A tunnel of this age ended: after at least a minute the pauses are short again.
  void ended(Duration lived);
  /// A tunnel was established: the configuration is right now.
  void connected() { misconfigured_before_ = false; }

 private:
  double jitter();

  std::uint64_t random_;
  Duration next_ = std::chrono::seconds(1);
  bool misconfigured_before_ = false;
  std::deque<SteadyTime> short_lives_;  ///< ends of the last tunnels that the server closed early
};

}  // namespace rubicon::networks::knx::line
