#pragma once

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// Accounts for the memory that each DDS participant makes this process use. A component has a participant of its own;
/// a participant with more than a few components is hostile, and is ignored for as long as it is present.
class Participants {
 public:
  static constexpr std::size_t kMaxComponents = 16;
  static constexpr std::size_t kMaxInterestBytes = 4UL << 20, kMaxInterestBytesOfAll = 64UL << 20;

  /// A component's start.
  using Start = std::pair<OwnerId, std::uint64_t>;

  bool is_banned(const Participant& who) const;
  /// False: the participant has kMaxComponents already.
  bool add(const Participant& who, const Start& start);
  void remove(const Participant& who, const Start& start);
  /// Returns the components of the participant, which are forgotten.
  std::vector<Start> ban(const Participant& who);
  /// The participant with most components; nullopt if none has more than one.
  std::optional<Participant> largest() const;

  /// False: the bound of bytes is reached.
  bool add_interest(const Participant& who, std::size_t bytes);
  void remove_interest(const Participant& who, std::size_t bytes);

  /// Ends the bans of all participants but these.
  void keep_only(const std::set<Participant>& there);
  void clear();

 private:
  struct Share {
    std::set<Start> starts;
    std::size_t interest_bytes = 0;
    bool banned = false;
    bool is_nothing() const { return starts.empty() && interest_bytes == 0 && !banned; }
  };
  void drop_if_nothing(const Participant& who);

  std::map<Participant, Share> shares_;
  std::size_t interest_bytes_ = 0;
};

}  // namespace rubicon::tuples::dds
