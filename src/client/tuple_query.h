#pragma once

#include <memory>
#include <set>

#include "client/peer_discovery.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// Collects all present tuples that match, once every owner has sent its snapshot. Owners that have sent none within
/// the patience are left out. A stop of this process uses up little of the patience. Destruction cancels the query
/// without a call.
class TupleQuery {
 public:
  /// Receives the owners that are left out, before the call with the tuples; none if only those are left out that were
  /// not discovered yet.
  using UnansweredCall = std::function<void(const std::vector<OwnerId>&)>;

  TupleQuery(Scheduler& scheduler, TupleSpace& space, PeerDiscovery& peer_discovery, Pattern pattern, TuplesCall call,
             Duration patience, UnansweredCall unanswered = {});

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
  std::set<OwnerId> answered_;
  bool over_ = false;
  tuples::Handle subscription_, peers_;
  Duration whole_patience_;
  Timer patience_, again_;
};

}  // namespace rubicon::client
