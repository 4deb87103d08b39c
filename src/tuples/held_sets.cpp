#include "tuples/held_sets.h"

#include <algorithm>
#include <utility>

namespace rubicon::tuples {

bool HeldSets::hold(const RemoteSet& set, SteadyTime now) {
  if (count_ >= kMax || bytes_ + set.value.size() > kMaxBytes) return false;
  held_[set.owner].push_back({set, now});
  ++count_;
  bytes_ += set.value.size();
  return true;
}

std::vector<RemoteSet> HeldSets::take(OwnerId owner, SteadyTime now) {
  auto taken = held_.extract(owner);
  std::vector<RemoteSet> sets;
  if (taken.empty()) return sets;
  for (auto& [set, since] : taken.mapped()) {
    --count_;
    bytes_ -= set.value.size();
    if (set.time_to_live > Duration(0))
      set.time_to_live = std::max<Duration>(set.time_to_live - (now - since), Duration(1));
    sets.push_back(std::move(set));
  }
  return sets;
}

std::vector<OwnerId> HeldSets::owners() const {
  std::vector<OwnerId> all;
  for (const auto& one : held_) all.push_back(one.first);
  return all;
}

void HeldSets::clear() {
  held_.clear();
  count_ = bytes_ = 0;
}

}  // namespace rubicon::tuples
