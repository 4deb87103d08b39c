#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "rubicon/tuple.hpp"

namespace rubicon::tuples::dds {

/// The remote sets to one component that wait for their replies: a component that is lost for a moment, as in a renewal
/// of its certificate, receives them again when it is back. It knows by their numbers which ones it had before.
class UnansweredSets {
 public:
  static constexpr std::size_t kMaxBytes = 32 * 1024 * 1024;

  struct TimedSet {
    RemoteSet set;
    SteadyTime since;
  };

  /// False: too much waits already.
  bool add(const RemoteSet& set, SteadyTime now);
  void answered(std::uint64_t request);
  /// Drops those whose time to live ended. The others, by their numbers.
  const std::map<std::uint64_t, TimedSet>& still_waiting(SteadyTime now);
  void clear();

 private:
  static std::size_t size_of(const RemoteSet& set);

  std::map<std::uint64_t, TimedSet> all_;
  std::size_t bytes_ = 0;
  std::size_t many_ = 64;  ///< time to look for those that ended
};

/// What was answered to all components, for requests that one repeats because it lost their replies. Of a refusal its
/// text is not kept.
class RecentReplies {
 public:
  static constexpr std::size_t kMostOfOne = 4096;  ///< of one component
  static constexpr std::size_t kMaxBytes = 16 * 1024 * 1024;

  explicit RecentReplies(std::size_t max_bytes = kMaxBytes) : max_bytes_(max_bytes) {}

  /// A request that the component did not send before.
  void asked(OwnerId by, std::uint64_t request);
  void answered(const Reply& reply);
  /// The answer to a request that was sent before: a refusal that says so if the reply is not kept any more. nullopt:
  /// it is still open.
  std::optional<Reply> repeat(OwnerId to, std::uint64_t request) const;
  /// Drops the replies to the component; what is open stays.
  void drop(OwnerId to);
  /// Forgets the component.
  void forget(OwnerId component);
  void clear();

 private:
  struct Kept {
    Verdict verdict{};
    ErrorCode code{};
    std::uint64_t sequence = 0, order = 0;
  };
  struct Component {
    std::map<std::uint64_t, Kept> replies;
    std::set<std::uint64_t> open;
  };
  using Replies = std::map<std::uint64_t, Kept>;
  /// With the nodes of both maps.
  static constexpr std::size_t kBytes = sizeof(Kept) + sizeof(OwnerId) + 3 * sizeof(std::uint64_t) + 2 * 48;

  void erase(Replies& replies, Replies::iterator reply);

  std::size_t max_bytes_;
  std::uint64_t next_ = 0;
  std::map<OwnerId, Component> components_;
  std::map<std::uint64_t, std::pair<OwnerId, std::uint64_t>> oldest_;  ///< component and request, by order
};

}  // namespace rubicon::tuples::dds
