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

/// The remote sets that pass from one engine to the other. The carrier knows each by a number of its own, which rises
/// over restarts of all that take part.
class ForwardedSets {
 public:
  static constexpr std::size_t kMax = 10'000, kMaxWaitingBytes = 32 * 1024 * 1024;
  /// A request without a time to live is forgotten after this.
  static constexpr Duration kMaxTime = std::chrono::seconds(60);

  struct Request {
    OwnerId owner{}, reader{};
    std::size_t asked = 0;  ///< engine where the reader asked the owner's stand-in
    std::size_t goes = 0;   ///< engine of the owner, where the reader has a stand-in
    std::uint64_t number = 0;
    std::uint64_t original = 0;  ///< number that the reader gave it
    std::uint64_t wire = 0;      ///< number that it has at the owner; 0 = not sent
    SteadyTime due{};            ///< an answer after this is not wanted
    std::optional<RemoteSet> waiting{};
  };

  /// `asked`, `goes`: engines, as in Request. 0 = too many.
  std::uint64_t add(OwnerId owner, std::size_t asked, std::size_t goes, const RemoteSet& set, SteadyTime now,
                    WallTime wall);
  /// Null: no such request.
  Request* find(std::uint64_t number);
  /// The number for the owner, who shows it with the outcome. It is the reader's number, unless the owner would take
  /// that for a repetition (it is not above `last`), or another request of the reader has it.
  std::uint64_t wire_number(const Request& request, std::uint64_t last) const;
  /// The number of the request that a reply to the stand-in of the reader on that engine answers; 0 = none.
  std::uint64_t answered(OwnerId reader, std::size_t goes, std::uint64_t wire) const;
  /// The set was sent with that number; only its answer is awaited.
  void sent(Request& request, std::uint64_t wire);
  /// Ends it: the request that was answered.
  std::optional<Request> take(std::uint64_t number);
  /// The first one that waits; 0 = none.
  std::uint64_t first_waiting(OwnerId owner, OwnerId reader) const;
  /// Whether the reader needs a stand-in on that engine.
  bool has(OwnerId reader, std::size_t goes) const { return of_reader_.contains({reader, goes}); }
  /// Ends those that are due, or that need the stand-in of a component on an engine.
  std::vector<Request> take_due(SteadyTime now);
  void forget(OwnerId component, std::size_t engine);
  SteadyTime next_due() const;

 private:
  void stop_waiting(Request& request);

  using Way = std::pair<OwnerId, OwnerId>;          ///< owner, reader
  using StandIn = std::pair<OwnerId, std::size_t>;  ///< reader, engine

  std::map<std::uint64_t, Request> requests_;
  std::map<Way, std::set<std::uint64_t>> waiting_;
  std::map<StandIn, std::size_t> of_reader_;
  std::map<std::pair<StandIn, std::uint64_t>, std::uint64_t> of_wire_;  ///< by reader and its number at the owner
  std::uint64_t last_ = 0;
  std::size_t waiting_bytes_ = 0;
};

}  // namespace rubicon::tuples::carry
