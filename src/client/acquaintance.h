#pragma once

#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::client {

/// Whether this component has probably met everybody who is there: nobody can know, so time decides.
class Acquaintance {
 public:
  /// Nobody new came for so long since the start.
  static constexpr Duration kQuiet = std::chrono::milliseconds(300);
  /// Who is asked for by name may take this long to show up.
  static constexpr Duration kNamed = std::chrono::seconds(1);

  Acquaintance(Scheduler& scheduler, TupleSpace& space);

  /// When `owner` (or everybody) will have been waited for, if nothing more happens.
  SteadyTime settled_at(std::optional<OwnerId> owner) const;
  bool settled(std::optional<OwnerId> owner) const { return scheduler_.now() >= settled_at(owner); }

 private:
  bool present(OwnerId id) const;

  Scheduler& scheduler_;
  TupleSpace& space_;
  SteadyTime started_, last_came_;
  tuples::Handle peers_;
};

}  // namespace rubicon::client
