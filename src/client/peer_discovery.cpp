#include "client/peer_discovery.h"

#include <algorithm>

namespace rubicon::client {

PeerDiscovery::PeerDiscovery(Scheduler& scheduler, TupleSpace& space, const DiscoveryPace& pace)
    : scheduler_(scheduler), space_(space), pace_(pace), started_(scheduler.now()), last_came_(started_) {
  peers_ = space.watch_peers([this](OwnerId, tuples::PeerEvent event) {
    if (event == tuples::PeerEvent::kUp) last_came_ = scheduler_.now();
  });
}

bool PeerDiscovery::present(OwnerId id) const {
  const auto there = space_.peers();
  return id == space_.self() || std::find(there.begin(), there.end(), id) != there.end();
}

SteadyTime PeerDiscovery::complete_at(std::optional<OwnerId> owner) const {
  if (!owner) return std::max(last_came_ + pace_.quiet, started_ + pace_.search);
  return present(*owner) ? started_ : started_ + pace_.named_owner;
}

}  // namespace rubicon::client
