#pragma once

#include <memory>
#include <set>

#include "client/peer_discovery.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// Collects all present tuples that match, once every owner has sent its snapshot. Destruction cancels it without a
/// call.
class TupleQuery {
 public:
  TupleQuery(Scheduler& scheduler, TupleSpace& space, const PeerDiscovery& peer_discovery, Pattern pattern,
             TuplesCall call, Duration patience);

 private:
  void check();
  bool complete() const;
  void end();

  Scheduler& scheduler_;
  TupleSpace& space_;
  const PeerDiscovery& peer_discovery_;
  Pattern pattern_;
  TuplesCall call_;
  std::set<OwnerId> answered_;
  bool over_ = false;
  tuples::Handle subscription_, peers_;
  Timer patience_, again_;
};

}  // namespace rubicon::client
