#pragma once

#include <cstdint>
#include <string>

#include "tuples/link.h"

namespace rubicon::tuples {

/// A component as it shows itself: what the policy knows when it decides.
struct PeerIdentity {
  OwnerId id{};
  std::uint64_t incarnation = 0;  ///< its start: microseconds since 1970 UTC by its own clock
  std::string host;               ///< where it runs, in its own words; equal on one host
};

/// Who a peer is and what it may. A link has one, and reports who comes and goes; the space asks it when a distant
/// subscription begins and before each remote set, never per publication. Authentication replaces the inside of this.
class PeerPolicy {
 public:
  virtual ~PeerPolicy() = default;
  /// Whether this may be seen as that component; the error says why not. Asked before anything else of the peer counts.
  virtual Result<void> may_join(const PeerIdentity& peer) = 0;
  /// A component that may come is up: from now on it is the one of that id, until it went.
  virtual void peer_up(const PeerIdentity& peer) = 0;
  virtual void peer_down(OwnerId peer) = 0;
  /// Whether the subscription of a component that is up may join own tuples.
  virtual Result<void> may_subscribe(OwnerId peer, const SubscriptionSpec& spec) = 0;
  /// Whether a component that is up may ask for this set; the error goes into the reply.
  virtual Result<void> may_set(const RemoteSet& set) = 0;
};

/// Everybody may everything: for links inside one process.
class OpenPolicy final : public PeerPolicy {
 public:
  Result<void> may_join(const PeerIdentity&) override { return {}; }
  void peer_up(const PeerIdentity&) override {}
  void peer_down(OwnerId) override {}
  Result<void> may_subscribe(OwnerId, const SubscriptionSpec&) override { return {}; }
  Result<void> may_set(const RemoteSet&) override { return {}; }
};

}  // namespace rubicon::tuples
