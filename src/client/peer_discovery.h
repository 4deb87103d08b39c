#pragma once

#include <functional>

#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::client {

/// How long discovery takes on the engines of a component.
struct DiscoveryPace {
  Duration quiet;        ///< it counts as complete when no peer came or went for this long
  Duration search;       ///< but not before this time
  Duration named_owner;  ///< how long an owner that is named may take to appear
};
inline constexpr DiscoveryPace kDdsPace{std::chrono::milliseconds(300), {}, std::chrono::seconds(1)};
/// Two processes that meet shake hands, for some 0.35 s, before one of them is a peer of the other. The handshakes of
/// all who are there run at the same time, so those who are slower follow soon.
inline constexpr DiscoveryPace kTrustPace{std::chrono::milliseconds(150), std::chrono::milliseconds(500),
                                          std::chrono::seconds(2)};
/// Kernels announce themselves each second, and have 0.5 s to say that they are components of ours.
inline constexpr DiscoveryPace kPeisPace{std::chrono::milliseconds(700), std::chrono::seconds(2),
                                         std::chrono::seconds(3)};

/// Estimates whether all components that are present have been discovered. No protocol can tell, so time decides, and
/// what the engine knows of components that are on their way. Time in which this process or its host was stopped counts
/// as one short observation, because this process could hear no component then; whoever is lost by it is awaited again.
class PeerDiscovery {
 public:
  /// Whether the engine has found a component that is no peer yet. It is waited for as long as for a named owner.
  using Expects = std::function<bool()>;

  PeerDiscovery(Scheduler& scheduler, TupleSpace& space, const DiscoveryPace& pace, Expects expects = {});

  /// When the discovery of `owner` (nullopt: of all) is complete if no further peer comes up. Later than that while one
  /// is expected: ask again then.
  SteadyTime complete_at(std::optional<OwnerId> owner);
  const DiscoveryPace& pace() const { return pace_; }
  bool complete(std::optional<OwnerId> owner) { return scheduler_.now() >= complete_at(owner); }

 private:
  bool present(OwnerId id) const;
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

}  // namespace rubicon::client
