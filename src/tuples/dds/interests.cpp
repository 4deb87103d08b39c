#include "tuples/dds/interests.h"

#include <utility>

namespace rubicon::tuples::dds {

namespace {

/// With the node of the map.
std::size_t cost(const SubscriptionSpec& spec) {
  return sizeof(SubscriptionSpec) + sizeof(Participant) + 64 + spec.pattern.key.size();
}

}  // namespace

const SubscriptionSpec* Interests::find(const InterestKey& key, const Participant& who) const {
  const auto slots = all_.find(start_of(key, who));
  if (slots == all_.end()) return nullptr;
  const auto found = slots->second.find(key.slot);
  return found == slots->second.end() ? nullptr : &found->second;
}

bool Interests::put(const InterestKey& key, const Participant& who, SubscriptionSpec spec) {
  erase(key, who);
  const auto slots = all_.find(start_of(key, who));
  if (slots != all_.end() && slots->second.size() >= kMaxOfOne) return false;
  if (!participants_.add_interest(who, cost(spec))) return false;
  all_[start_of(key, who)].insert_or_assign(key.slot, std::move(spec));
  return true;
}

void Interests::erase(const InterestKey& key, const Participant& who) {
  const auto slots = all_.find(start_of(key, who));
  if (slots == all_.end()) return;
  const auto found = slots->second.find(key.slot);
  if (found == slots->second.end()) return;
  participants_.remove_interest(who, cost(found->second));
  slots->second.erase(found);
  if (slots->second.empty()) all_.erase(slots);
}

std::vector<SubscriptionSpec> Interests::of(OwnerId subscriber, std::uint64_t incarnation,
                                            const Participant& who) const {
  std::vector<SubscriptionSpec> specs;
  const auto slots = all_.find({subscriber, incarnation, who});
  if (slots == all_.end()) return specs;
  for (const auto& [slot, spec] : slots->second) specs.push_back(spec);
  return specs;
}

void Interests::erase_all(const Participant& who) {
  std::vector<InterestKey> gone;
  for (const auto& [start, slots] : all_) {
    const auto& [subscriber, incarnation, participant] = start;
    if (participant != who) continue;
    for (const auto& [slot, spec] : slots) gone.push_back({subscriber, incarnation, slot});
  }
  for (const auto& key : gone) erase(key, who);
}

std::set<Participant> Interests::participants() const {
  std::set<Participant> all;
  for (const auto& [start, slots] : all_) all.insert(std::get<Participant>(start));
  return all;
}

}  // namespace rubicon::tuples::dds
