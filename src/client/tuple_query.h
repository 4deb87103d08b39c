#pragma once

#include <functional>
#include <memory>
#include <set>

#include "base/scheduler.h"
#include "rubicon/client.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::client {

/// How long discovery takes on the engines of a component.
struct DiscoveryPace {
  Duration quiet;        ///< it counts as complete when no peer came or went for this long
  Duration search;       ///< but not before this time
  Duration expected;     ///< how long one that is on its way is waited for
  bool is_fact = false;  ///< a component that is neither present nor awaited does not exist
};
inline constexpr DiscoveryPace kDdsPace{std::chrono::milliseconds(300), {}, std::chrono::seconds(1)};
/// The sockets of the folder are all there are.
inline constexpr DiscoveryPace kHostPace{{}, {}, std::chrono::hours(1), true};
/// Kernels announce themselves each second, and have 0.5 s to say that they are components of ours.
inline constexpr DiscoveryPace kPeisPace{std::chrono::milliseconds(700), std::chrono::seconds(2),
                                         std::chrono::seconds(3)};

/// Whether all components that are present have been discovered. On a host that is a fact. Elsewhere no protocol can
/// tell, so time decides, and what the engine knows of components that are on their way. Time in which this process or
/// its host was stopped counts as one short observation, because this process could hear no component then. A component
/// that was lost in that time is awaited again.
class PeerDiscovery {
 public:
  /// Whether there may be a component that is not a peer yet, beside those that a link seeks: that one, or any.
  using Expects = std::function<bool(std::optional<OwnerId>)>;

  PeerDiscovery(Scheduler& scheduler, TupleSpace& space, const DiscoveryPace& pace, Expects expects = {});

  /// When all are discovered if no further peer comes up. Later than that while one is expected: ask again then.
  SteadyTime complete_at();
  /// The same of one that is named: it has the patience since the beginning, however often it is asked for, and longer
  /// while an engine looks for it.
  SteadyTime complete_at(OwnerId owner, Duration patience);
  /// Whether it is there; nullopt: not known.
  std::optional<bool> has(OwnerId owner) const;
  bool complete() { return scheduler_.now() >= complete_at(); }

 private:
  bool present(OwnerId id) const;
  bool is_sought(std::optional<OwnerId> owner) const;
  SteadyTime next_look() const;
  void observe();
  void notice_stop();

  Scheduler& scheduler_;
  TupleSpace& space_;
  DiscoveryPace pace_;
  Expects expects_;
  SteadyTime started_, last_change_, noticed_;
  bool left_alone_ = false;  ///< since `started_`: the last one was lost
  bool observes_ = false;    ///< whether `again_` measures stops
  Timer again_;
  tuples::Handle peers_;
};

/// Collects all present tuples that match, once every owner has sent its snapshot. Owners that have sent none within
/// the patience are left out. A stop of this process uses up little of the patience. Destruction cancels the query
/// without a call.
class TupleQuery {
 public:
  /// Receives the owners that are left out, before the call with the tuples; none if only those are left out that were
  /// not discovered yet.
  using UnansweredCall = std::function<void(const std::vector<OwnerId>&)>;
  /// Whether a tuple that matches is collected.
  using Wanted = std::function<bool(const tuples::TupleView&)>;

  TupleQuery(Scheduler& scheduler, TupleSpace& space, PeerDiscovery& peer_discovery, Pattern pattern, TuplesCall call,
             Duration patience, UnansweredCall unanswered = {}, Wanted wanted = {});

 private:
  SteadyTime found_at();
  void check();
  void wait(Duration patience);
  std::vector<OwnerId> unanswered() const;
  void end();

  Scheduler& scheduler_;
  TupleSpace& space_;
  PeerDiscovery& peer_discovery_;
  Pattern pattern_;
  TuplesCall call_;
  UnansweredCall unanswered_call_;
  Wanted wanted_;
  std::set<OwnerId> answered_;
  bool over_ = false;
  tuples::Handle subscription_, peers_;
  Duration whole_patience_;
  Timer patience_, again_;
};

}  // namespace rubicon::client
