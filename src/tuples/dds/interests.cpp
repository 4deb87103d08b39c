#include "tuples/dds/interests.h"

namespace rubicon::tuples::dds {

/// With the node of the map.
std::size_t Interests::cost(const Interest& interest) {
  return sizeof(Interest) + 64 + interest.spec.pattern.key.size();
}

const Interests::Interest* Interests::find(const InterestKey& key) const {
  const auto slots = all_.find({key.subscriber, key.incarnation});
  if (slots == all_.end()) return nullptr;
  const auto found = slots->second.find(key.slot);
  return found == slots->second.end() ? nullptr : &found->second;
}

bool Interests::put(const InterestKey& key, Interest interest) {
  const auto* before = find(key);
  if (before && before->participant != interest.participant) return false;
  if (before) erase(key);
  const auto slots = all_.find({key.subscriber, key.incarnation});
  if (slots != all_.end() && slots->second.size() >= kMaxOfOne) return false;
  if (!participants_.add_interest(interest.participant, cost(interest))) return false;
  all_[{key.subscriber, key.incarnation}].insert_or_assign(key.slot, std::move(interest));
  return true;
}

void Interests::erase(const InterestKey& key) {
  const auto slots = all_.find({key.subscriber, key.incarnation});
  if (slots == all_.end()) return;
  const auto found = slots->second.find(key.slot);
  if (found == slots->second.end()) return;
  participants_.remove_interest(found->second.participant, cost(found->second));
  slots->second.erase(found);
  if (slots->second.empty()) all_.erase(slots);
}

std::vector<SubscriptionSpec> Interests::of(OwnerId subscriber, std::uint64_t incarnation,
                                            const Participant& who) const {
  std::vector<SubscriptionSpec> specs;
  const auto slots = all_.find({subscriber, incarnation});
  if (slots == all_.end()) return specs;
  for (const auto& [slot, interest] : slots->second) {
    if (interest.participant == who) specs.push_back(interest.spec);
  }
  return specs;
}

void Interests::erase_all(const Participant& who) {
  std::vector<InterestKey> gone;
  for (const auto& [start, slots] : all_) {
    for (const auto& [slot, interest] : slots) {
      if (interest.participant == who) gone.push_back({start.first, start.second, slot});
    }
  }
  for (const auto& key : gone) erase(key);
}

}  // namespace rubicon::tuples::dds
