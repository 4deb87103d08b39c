#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/tuple.hpp"

namespace rubicon::tuples::carry {

/// The remote sets that pass from one engine to the other. Each gets a number of the carrier's own, which rises over
/// restarts of all that take part: owners drop a number that they saw before.
class ForwardedSets {
 public:
  static constexpr std::size_t kMax = 10'000, kMaxWaitingBytes = 32 * 1024 * 1024;
  /// A request without a time to live is forgotten after this.
  static constexpr Duration kLongest = std::chrono::seconds(60);

  struct Request {
    OwnerId owner{}, reader{};
    std::uint64_t original = 0;  ///< number that the reader gave it
    SteadyTime due{};            ///< an answer after this is not wanted
    std::optional<RemoteSet> waiting{};
  };

  /// 0 = too many.
  std::uint64_t add(OwnerId owner, const RemoteSet& set, SteadyTime now, WallTime wall);
  /// Null: no such request.
  Request* find(std::uint64_t number);
  /// It was sent: only its answer matters.
  void sent(Request& request);
  /// Ends it: the request that was answered.
  std::optional<Request> take(std::uint64_t number);
  /// The first one that waits; 0 = none.
  std::uint64_t first_waiting(OwnerId owner, OwnerId reader) const;
  bool has(OwnerId reader) const { return of_reader_.contains(reader); }
  /// Ends those that are due, or that concern a component.
  std::vector<Request> take_due(SteadyTime now);
  void forget(OwnerId component);
  SteadyTime next_due() const;

 private:
  using Way = std::pair<OwnerId, OwnerId>;  ///< owner, reader

  std::map<std::uint64_t, Request> requests_;
  std::map<Way, std::set<std::uint64_t>> waiting_;
  std::map<OwnerId, std::size_t> of_reader_;
  std::uint64_t last_ = 0;
  std::size_t waiting_bytes_ = 0;
};

}  // namespace rubicon::tuples::carry
