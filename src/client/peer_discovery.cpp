#include "client/peer_discovery.h"

#include <algorithm>

namespace rubicon::client {

namespace {

/// While components are expected.
constexpr Duration kLookAgain = std::chrono::milliseconds(20);

}  // namespace

PeerDiscovery::PeerDiscovery(Scheduler& scheduler, TupleSpace& space, const DiscoveryPace& pace, Expects expects)
    : scheduler_(scheduler),
      space_(space),
      pace_(pace),
      expects_(std::move(expects)),
      started_(scheduler.now()),
      last_came_(started_) {
  peers_ = space.watch_peers([this](OwnerId, tuples::PeerEvent event) {
    if (event == tuples::PeerEvent::kUp) last_came_ = scheduler_.now();
  });
}

bool PeerDiscovery::present(OwnerId id) const {
  const auto there = space_.peers();
  return id == space_.self() || std::find(there.begin(), there.end(), id) != there.end();
}

SteadyTime PeerDiscovery::complete_at(std::optional<OwnerId> owner) const {
  if (owner) return present(*owner) ? started_ : started_ + pace_.named_owner;
  const auto usual = std::max(last_came_ + pace_.quiet, started_ + pace_.search);
  const auto now = scheduler_.now(), longest = started_ + pace_.named_owner;
  if (usual > now || now >= longest || !expects_ || !expects_()) return usual;
  return std::min(now + kLookAgain, longest);
}

}  // namespace rubicon::client
