#pragma once

#include "tuples/link.h"

namespace rubicon::tuples {

/// Decides who a peer is and what it may do. A link has one and reports peers that come up and go down; the space asks
/// it when a distant subscription begins and before each remote set, never per publication. Authentication will be
/// another implementation.
class PeerPolicy {
 public:
  virtual ~PeerPolicy() = default;
  /// Whether to accept this peer as that component; the error says why not. Asked before anything else of the peer.
  virtual Result<void> may_join(const PeerIdentity& peer) = 0;
  /// A component that may join is up: the one with that id until peer_down().
  virtual void peer_up(const PeerIdentity& peer) = 0;
  virtual void peer_down(OwnerId peer) = 0;
  /// Whether the subscription of a component that is up may join own tuples.
  virtual Result<void> may_subscribe(OwnerId peer, const SubscriptionSpec& spec) = 0;
  /// Whether a component that is up may ask for this set; the error goes into the reply.
  virtual Result<void> may_set(const RemoteSet& set) = 0;
};

/// Allows everything: for links inside one process.
class OpenPolicy final : public PeerPolicy {
 public:
  Result<void> may_join(const PeerIdentity&) override { return {}; }
  void peer_up(const PeerIdentity&) override {}
  void peer_down(OwnerId) override {}
  Result<void> may_subscribe(OwnerId, const SubscriptionSpec&) override { return {}; }
  Result<void> may_set(const RemoteSet&) override { return {}; }
};

}  // namespace rubicon::tuples
