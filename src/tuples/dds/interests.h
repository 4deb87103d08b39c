#pragma once

#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "tuples/dds/participants.h"
#include "tuples/link.h"

namespace rubicon::tuples::dds {

/// Identifies an interest: a slot of one start of a component.
struct InterestKey {
  OwnerId subscriber{};
  std::uint64_t incarnation = 0;
  std::uint32_t slot = 0;
  friend auto operator<=>(const InterestKey&, const InterestKey&) = default;
};

/// The subscriptions of other components, including those whose presence has not arrived. Bounded per component, and in
/// bytes per participant and in all.
class Interests {
 public:
  static constexpr std::size_t kMaxOfOne = 10'000;

  explicit Interests(Participants& participants) : participants_(participants) {}

  const SubscriptionSpec* find(const InterestKey& key, const Participant& who) const;
  /// Replaces what the participant had in the slot; what another one has there stays, and counts if that one is the
  /// component. False: a bound is reached.
  bool put(const InterestKey& key, const Participant& who, SubscriptionSpec spec);
  void erase(const InterestKey& key, const Participant& who);
  /// The subscriptions of one start of a component, by slot, that this participant wrote.
  std::vector<SubscriptionSpec> of(OwnerId subscriber, std::uint64_t incarnation, const Participant& who) const;
  /// Removes those of a participant that is gone or banned.
  void erase_all(const Participant& who);
  /// Whose there are any.
  std::set<Participant> participants() const;
  void clear() { all_.clear(); }

 private:
  using Start = std::tuple<OwnerId, std::uint64_t, Participant>;
  using Slots = std::map<std::uint32_t, SubscriptionSpec>;
  static Start start_of(const InterestKey& key, const Participant& who) {
    return {key.subscriber, key.incarnation, who};
  }

  Participants& participants_;
  std::map<Start, Slots> all_;
};

}  // namespace rubicon::tuples::dds
