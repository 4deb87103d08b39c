#include "tuples/held_sets.h"

#include <algorithm>
#include <utility>

namespace rubicon::tuples {

namespace {

/// Wires count in microseconds, and 0 means no end there.
bool has_ended(const HeldSets::Held& one, SteadyTime now) {
  const auto lives = one.set.time_to_live;
  return lives < Duration(0) || (lives > Duration(0) && lives - (now - one.since) < std::chrono::microseconds(1));
}

}  // namespace

bool HeldSets::hold(const RemoteSet& set, SteadyTime now) {
  if (count_ >= kMax) drop_ended(now);
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
    if (has_ended({set, since}, now)) continue;
    if (set.time_to_live > Duration(0)) set.time_to_live -= now - since;
    sets.push_back(std::move(set));
  }
  return sets;
}

void HeldSets::drop_ended(SteadyTime now) {
  for (auto of_owner = held_.begin(); of_owner != held_.end();) {
    std::erase_if(of_owner->second, [&](const Held& one) {
      const bool ended = has_ended(one, now);
      count_ -= ended ? 1 : 0;
      bytes_ -= ended ? one.set.value.size() : 0;
      return ended;
    });
    of_owner = of_owner->second.empty() ? held_.erase(of_owner) : std::next(of_owner);
  }
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
