#include <fmt/format.h>

#include "tuples/carry/carrier.h"

namespace rubicon::tuples::carry {

/// Whether that component carries the same between engines where it is met itself.
void Carrier::review_carrier(OwnerId id) {
  Pairs pairs;
  const auto found = known_.find(id);
  for (std::size_t other = 0; found != known_.end() && other < engines_.size(); ++other) {
    if (!is_met(found->second, other)) continue;
    const auto announced = announcement_of(found->second.at[other].meeting->summary);
    for (std::size_t one = 0; one < other && !announced.empty(); ++one) {
      const auto pair = pair_name(engines_[one].name, engines_[other].name);
      const auto theirs = announced.find(pair);
      const auto ours = carries_.find(pair);
      if (!is_met(found->second, one) || theirs == announced.end() || ours == carries_.end()) continue;
      if (theirs->second == ours->second) pairs.emplace(one, other);
    }
  }
  const auto known = others_.find(id);
  if (known == others_.end() ? pairs.empty() : known->second == pairs) return;
  others_.erase(id);
  for (const auto& [one, other] : pairs) {
    log_.unlimited().info(fmt::format("component {} carries the same between {} and {}: {} does", number(id),
                                      engines_[one].name, engines_[other].name,
                                      number(id) < number(self_) ? "it" : "this island"));
  }
  if (!pairs.empty()) others_.emplace(id, std::move(pairs));
  for (const auto& one : known_) review_at(scheduler_.now(), one.first);
}

/// Between the same two engines the carrier with the lowest id carries, of those whose stand-in others believe.
bool Carrier::gives_way(OwnerId id, std::size_t origin, std::size_t to) const {
  for (const auto& [other, pairs] : others_) {
    if (number(other) > number(self_)) return false;
    if (pairs.contains(std::minmax(origin, to)) && engines_[to].ecology.may_stand_in(other, id)) return true;
  }
  return false;
}

/// Those with other rules, and earlier releases, do not know of each other: who was first carries.
void Carrier::warn_of_carriers(OwnerId id, const Known& known) {
  for (std::size_t to = 0; to < known.at.size(); ++to) {
    const auto& meeting = known.at[to].meeting;
    const auto carrier = meeting ? carrier_of(meeting->identity.host) : model::kNoOwner;
    const auto other = known_.find(carrier);
    if (carrier == self_ || other == known_.end() || others_.contains(carrier)) continue;
    for (std::size_t from = 0; from < known.at.size(); ++from) {
      if (!is_met(other->second, from) || !is_met(other->second, to)) continue;
      if (!is_met(known, from) || !rules_.carries_any_of(id, {engines_[from].name, engines_[to].name})) continue;
      if (const auto ready = known.changed + kSettle; ready > scheduler_.now()) return review_at(ready, id);
      log_.warning(fmt::format("carrier {}", number(carrier)),
                   fmt::format("component {} carries component {} to {} too, with other rules: give both the same, or "
                               "configure one island to carry it",
                               number(carrier), number(id), engines_[to].name));
    }
  }
}

}  // namespace rubicon::tuples::carry
