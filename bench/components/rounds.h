#pragma once

#include <vector>

#include "components/processes.h"
#include "components/report.h"

namespace rubicon::bench {

// Single rounds of measurements that several programs make, each over its own engine.

/// Of a figure in each round.
double median_of(const std::vector<Json>& rounds, const char* name);

/// A writer and a sink: what both say, `lost` (sets that were neither merged nor delivered) and `stale` (tuples whose
/// last copy is not the owner's) once nothing came for `settle_ms` after the last set.
Json stream_round(const Meeting& meeting, std::size_t keys, double seconds, int settle_ms = 300);

/// A commander and a desk: what both say, and `faults`: sets that were not applied, lost, repeated or out of order.
Json commands_round(const Meeting& meeting, std::uint64_t count);

/// Seconds from a signal that ends or stops a subscriber to the end of demand at its owner.
double end_round(const Meeting& meeting, int signal);

/// Half round trips of 64-byte values, and those of the same bytes on a bare connection right before: roles `bare-ping`
/// and `bare-pong` of the program.
struct PingRounds {
  std::vector<Json> ours, bare;

  void add(const Plan& plan, const Meeting& meeting, int pace_us);
  /// Median of the ratios of rounds, because the load of the machine changes between them.
  double ratio(const char* name) const;
};
/// Medians `p50` and `p99`.
Json percentiles_of(const std::vector<Json>& rounds);

/// When components of a crowd have settled, and how long they are idle then; in seconds.
struct CrowdTimes {
  double settled = 12, idle = 20;
  bool of_any_owner = false;  ///< each subscribes to tuples of any owner
};
/// So many components, started at once.
std::vector<Child> start_crowd(const Meeting& meeting, int count, const CrowdTimes& times);
std::vector<Json> results_of(std::vector<Child>& children);
/// When the last one saw all; zero: one does not see all.
double slowest_of(const std::vector<Json>& crowd);

}  // namespace rubicon::bench
