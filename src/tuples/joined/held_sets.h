#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/tuple.hpp"

namespace rubicon::tuples::joined {

/// Remote sets to components of which only a stand-in is met so far: they wait a little for the component itself. A
/// carrier does not pass on what comes from a component that is on both engines.
class HeldSets {
 public:
  static constexpr std::size_t kMax = 1000, kMaxBytes = 4 * 1024 * 1024;

  struct Held {
    RemoteSet set;
    SteadyTime since{};
  };

  bool has(OwnerId owner) const { return held_.contains(owner); }
  /// False: too many, or too large.
  bool hold(const RemoteSet& set, SteadyTime now);
  /// Those to this owner, in their order.
  std::vector<RemoteSet> take(OwnerId owner, SteadyTime now);
  std::vector<OwnerId> owners() const;
  void clear();

 private:
  std::map<OwnerId, std::vector<Held>> held_;
  std::size_t count_ = 0, bytes_ = 0;
};

}  // namespace rubicon::tuples::joined
