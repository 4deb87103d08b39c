#pragma once

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// What each DDS participant takes of our memory. A component has one of its own; who shows more than a few is there to
/// do harm, and is ignored for as long as DDS sees it.
class Participants {
 public:
  static constexpr std::size_t kMostComponents = 16;
  static constexpr std::size_t kMostInterestBytes = 4UL << 20, kMostInterestBytesOfAll = 64UL << 20;

  /// A component's start.
  using Start = std::pair<OwnerId, std::uint64_t>;

  bool is_banned(const Participant& who) const;
  /// False: that is one more than a participant may have.
  bool add(const Participant& who, const Start& start);
  void remove(const Participant& who, const Start& start);
  /// Its components, which are no more.
  std::vector<Start> ban(const Participant& who);
  /// Who has most components, if more than one.
  std::optional<Participant> greatest() const;

  /// False: there is no room for so many bytes of interests.
  bool add_interest(const Participant& who, std::size_t bytes);
  void remove_interest(const Participant& who, std::size_t bytes);

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
