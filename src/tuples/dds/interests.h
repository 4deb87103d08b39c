#pragma once

#include <map>

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

  struct Interest {
    Participant participant{};
    SubscriptionSpec spec;
  };

  explicit Interests(Participants& participants) : participants_(participants) {}

  const Interest* find(const InterestKey& key) const;
  /// Replaces what the same participant had in the slot. False: a bound is reached, or another participant has the
  /// slot.
  bool put(const InterestKey& key, Interest interest);
  void erase(const InterestKey& key);
  /// The subscriptions of one start of a component, by slot; only those that its own participant wrote.
  std::vector<SubscriptionSpec> of(OwnerId subscriber, std::uint64_t incarnation, const Participant& who) const;
  /// Removes those of a participant that is gone or banned.
  void erase_all(const Participant& who);
  void clear() { all_.clear(); }

 private:
  using Slots = std::map<std::uint32_t, Interest>;
  static std::size_t cost(const Interest& interest);

  Participants& participants_;
  std::map<std::pair<OwnerId, std::uint64_t>, Slots> all_;
};

}  // namespace rubicon::tuples::dds
