#pragma once

#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::client {

/// Estimates whether all components that are present have been discovered. No protocol can tell, so time decides.
class PeerDiscovery {
 public:
  /// Discovery counts as complete when no peer came up for this long.
  static constexpr Duration kQuietPeriod = std::chrono::milliseconds(300);
  /// How long an owner that is named may take to appear.
  static constexpr Duration kNamedOwnerWait = std::chrono::seconds(1);

  PeerDiscovery(Scheduler& scheduler, TupleSpace& space);

  /// When the discovery of `owner` (nullopt: of all) is complete if no further peer comes up.
  SteadyTime complete_at(std::optional<OwnerId> owner) const;
  bool complete(std::optional<OwnerId> owner) const { return scheduler_.now() >= complete_at(owner); }

 private:
  bool present(OwnerId id) const;

  Scheduler& scheduler_;
  TupleSpace& space_;
  SteadyTime started_, last_came_;
  tuples::Handle peers_;
};

}  // namespace rubicon::client
