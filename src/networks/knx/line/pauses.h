#pragma once

#include <cstdint>
#include <deque>
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
