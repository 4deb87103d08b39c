#pragma once

#include "base/scheduler.h"

namespace rubicon::tuples::dds {

/// Whether this process may have missed that a member was revoked: it has just started, or it slept so long
/// that others may have lost it, stopped or with its host. Another member brings the list within that time; until then
/// it takes no requests.
class CatchUp {
 public:
  static constexpr Duration kAfterStart = std::chrono::seconds(1), kAfterSleep = std::chrono::seconds(2);

  /// The scheduler must outlive the object. `lease`: after which others lose this process.
  CatchUp(Scheduler& scheduler, Duration lease);

  /// This process was outside of the ecology.
  void begin();
  /// How long it still lasts; zero = it is over.
  Duration left();

 private:
  void look();
  void tick();

  Scheduler& scheduler_;
  const Duration lease_;
  SteadyTime until_, looked_;
  WallTime looked_by_wall_;  ///< goes on while the host sleeps
  Timer timer_;
};

}  // namespace rubicon::tuples::dds
