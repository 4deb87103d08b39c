#pragma once

#include "tuples/judge.h"
#include "tuples/link.h"

namespace rubicon::tuples {

/// Decides who a peer is and what it may do. A link has one and reports peers that come up and go down; the space asks
/// it when a distant subscription begins or joins a tuple and before each remote set, never per publication.
class PeerPolicy {
 public:
  virtual ~PeerPolicy() = default;
  /// Whether to accept this peer as that component; the error says why not. Asked before anything else of the peer.
  virtual Result<void> may_join(const PeerIdentity& peer) = 0;
  /// A component that may join is up: the one with that id until peer_down(). Again: it is another member now.
  virtual void peer_up(const PeerIdentity& peer) = 0;
  virtual void peer_down(OwnerId peer) = 0;
  /// Whether the subscription of a component that is up may join own tuples.
  virtual Result<void> may_subscribe(OwnerId peer, const SubscriptionSpec& spec) = 0;
  /// Whether a component that is up may ask for this set; the error goes into the reply.
  virtual Result<void> may_set(const RemoteSet& set) = 0;
  /// Whether a component that is up may send messages there, as Judge::may_send().
  virtual Result<void> may_send(OwnerId peer, std::string_view where) = 0;
  /// A set was answered, whoever refused it.
  virtual void answered(const RemoteSet& set, const Reply& reply) = 0;
  /// Who that component is; nullptr: not up, or the engine does not know. Valid until peer_down(), or
  /// peer_up() again: for the present turn.
  virtual const Member* member(OwnerId peer) const = 0;
  /// Who is judged for a set: its sender, or whom that names and may vouch for; nullptr: the process itself, or the
  /// engine does not know. Valid until the next call, and at most until peer_down().
  virtual const Member* asker(const RemoteSet& set) = 0;
  /// The host of a component that is up, as it declares it; empty: not up, or not known. Valid until peer_down().
  virtual std::string_view host(OwnerId peer) const = 0;
  /// The judge of what members may do; nullptr: none.
  virtual Judge* judge() = 0;
  /// Whether subscriptions of the component are judged for each own tuple they cover, by access().
  virtual bool filters(OwnerId peer) const = 0;
  /// What a subscription of the component gets of an own tuple. Only asked where filters() is true.
  virtual Access access(OwnerId peer, std::string_view key) const = 0;
};

/// Allows everything: for links inside one process.
class OpenPolicy : public PeerPolicy {
 public:
  Result<void> may_join(const PeerIdentity&) override { return {}; }
  void peer_up(const PeerIdentity&) override {}
  void peer_down(OwnerId) override {}
  Result<void> may_subscribe(OwnerId, const SubscriptionSpec&) override { return {}; }
  Result<void> may_set(const RemoteSet&) override { return {}; }
  Result<void> may_send(OwnerId, std::string_view) override { return {}; }
  void answered(const RemoteSet&, const Reply&) override {}
  const Member* member(OwnerId) const override { return nullptr; }
  const Member* asker(const RemoteSet&) override { return nullptr; }
  std::string_view host(OwnerId) const override { return {}; }
  Judge* judge() override { return nullptr; }
  bool filters(OwnerId) const override { return false; }
  Access access(OwnerId, std::string_view) const override { return {}; }
};

}  // namespace rubicon::tuples
