#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/summary.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::tuples {

class PeerPolicy;

/// One subscription as it travels to owners.
struct SubscriptionSpec {
  std::uint32_t id = 0;  ///< unique per subscriber
  Pattern pattern;
  Flow flow;
};

/// One changed tuple on its way to a subscriber; the views live as long as the call. tuple.owner is the sender. An
/// empty key with a subscription's id as sequence ends the snapshot of that subscription; with 0 it begins anew: the
/// sender lost sight of this subscriber, and what follows counts, whatever came before. Links carry both like any
/// other.
using Change = Event;

/// What a Link tells its TupleSpace; never from inside a call of the space into the link.
class LinkListener {
 public:
  virtual ~LinkListener() = default;
  virtual void on_changes(OwnerId owner, std::span<const Change> changes) = 0;
  virtual void on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) = 0;
  virtual void on_unsubscribe(OwnerId subscriber, std::uint32_t id) = 0;
  virtual void on_remote_set(const RemoteSet& wish) = 0;
  virtual void on_reply(const Reply& reply) = 0;
  /// kLeft and kLost also end the peer's subscriptions; its cached tuples stay readable until its owner is back.
  virtual void on_peer(OwnerId peer, PeerEvent event) = 0;
  /// What a component that is up says of itself: after kUp unless it is empty, and whenever it changes.
  virtual void on_summary(OwnerId peer, std::string_view summary) = 0;
};

/// How tuple spaces reach each other: one end of an ecology, for one component. Owned by runtime; outlives the space.
/// Everything is asynchronous and ordered per pair of components. Nothing blocks.
class Link {
 public:
  virtual ~Link() = default;

  /// From now on the listener is told; peers already there are announced in a later turn. nullptr detaches.
  virtual void attach(LinkListener* listener) = 0;

  /// Hands over the tuples that changed for this subscriber in this turn, each at most once, latest value. False =
  /// no room now: nothing was taken, try again a little later.
  virtual bool publish(OwnerId subscriber, std::span<const Change> changes) = 0;

  virtual void subscribe(const SubscriptionSpec& spec) = 0;
  virtual void unsubscribe(std::uint32_t id) = 0;
  /// kNotFound when no such owner is present, kBusy when the bounded window is full.
  virtual Result<void> remote_set(const RemoteSet& wish) = 0;
  virtual void reply(const Reply& reply) = 0;
  virtual std::vector<OwnerId> peers() const = 0;
  /// What all others see of this component without subscribing; at most kMaxSummary. Kept over attach().
  virtual void describe(std::string summary) = 0;
  /// Asked by the space, which is told of no component that may not come. Lives as long as the link.
  virtual PeerPolicy& policy() = 0;
};

/// Where the links of a process come from: an engine, opened.
class Ecology {
 public:
  virtual ~Ecology() = default;
  /// kDuplicate if this process has a component of that id, kIo if the engine cannot make the link.
  virtual Result<std::unique_ptr<Link>> join(OwnerId id) = 0;
};

}  // namespace rubicon::tuples
