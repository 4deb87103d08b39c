#pragma once

#include <map>

#include "tuples/dds/participants.h"
#include "tuples/link.h"

namespace rubicon::tuples::dds {

/// Whose an interest is: a slot of one start of a component.
struct InterestKey {
  OwnerId subscriber{};
  std::uint64_t incarnation = 0;
  std::uint32_t slot = 0;
  friend auto operator<=>(const InterestKey&, const InterestKey&) = default;
};

/// What other components subscribe to, also those whose presence was not seen yet. Bounded per component, and in bytes
/// per participant and in all.
class Interests {
 public:
  static constexpr std::size_t kMostOfOne = 10'000;

  struct Interest {
    Participant participant{};
    SubscriptionSpec spec;
  };

  explicit Interests(Participants& participants) : participants_(participants) {}

  const Interest* find(const InterestKey& key) const;
  /// In place of what the same participant had there. False: there is no room, or the slot is another participant's.
  bool put(const InterestKey& key, Interest interest);
  void erase(const InterestKey& key);
  /// Of one start of a component, by slot; only what its own participant wrote.
  std::vector<SubscriptionSpec> of(OwnerId subscriber, std::uint64_t incarnation, const Participant& who) const;
  /// Those of a participant that is not there any more, or is ignored.
  void erase_all(const Participant& who);
  void clear() { all_.clear(); }

 private:
  using Slots = std::map<std::uint32_t, Interest>;
  static std::size_t cost(const Interest& interest);

  Participants& participants_;
  std::map<std::pair<OwnerId, std::uint64_t>, Slots> all_;
};

}  // namespace rubicon::tuples::dds
