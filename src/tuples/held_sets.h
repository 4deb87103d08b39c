#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/tuple.hpp"

namespace rubicon::tuples {

/// Remote sets that wait a little until their owners are met: the engine looks for them, or has met only stand-ins so
/// far. Bounded.
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
  /// Those to this owner whose time to live goes on, in their order.
  std::vector<RemoteSet> take(OwnerId owner, SteadyTime now);
  std::vector<OwnerId> owners() const;
  /// Those whose time to live ended are answered already.
  void drop_ended(SteadyTime now);
  void clear();

 private:
  std::map<OwnerId, std::vector<Held>> held_;
  std::size_t count_ = 0, bytes_ = 0;
};

}  // namespace rubicon::tuples
