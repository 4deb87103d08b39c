#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "rubicon/summary.hpp"
#include "tuples/change.h"
#include "tuples/member.h"

namespace rubicon::tuples {

class PeerPolicy;

/// One subscription as it is sent to owners.
struct SubscriptionSpec {
  std::uint32_t id = 0;  ///< unique per subscriber, not 0
  Pattern pattern;
  Flow flow;
};

/// What a component declares about itself, and who it is as the engine proved.
struct PeerIdentity {
  OwnerId id{};
  /// Its start: microseconds since 1970 UTC, by its own clock, and the same on every engine. Components of other
  /// programs may have another number here, below that of the year 2000.
  std::uint64_t incarnation = 0;
  std::string host;  ///< identifies its host; equal for all components of a host, on every engine
  std::shared_ptr<const Member> member = nullptr;  ///< null: the engine does not know
  bool own_process = false;  ///< a component of this process, as the engine itself knows; never what the peer declares
  bool by_kernel = false;    ///< the kernel of this host vouches for its process
};

/// As subscriber: the link itself, which some engines need to know all own tuples. No component has this id.
inline constexpr OwnerId kLinkItself{0xffffffff};

/// Receives what a Link brings; never called inside a call of the space into the link.
class LinkListener {
 public:
  virtual ~LinkListener() = default;
  virtual void on_changes(OwnerId owner, std::span<const Change> changes) = 0;
  virtual void on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) = 0;
  virtual void on_unsubscribe(OwnerId subscriber, std::uint32_t id) = 0;
  virtual void on_remote_set(const RemoteSet& set) = 0;
  /// `from`: who answers, as the engine knows. False: it is not the owner that was asked; the reply does not count.
  virtual bool on_reply(OwnerId from, const Reply& reply) = 0;
  /// kLeft and kLost also end the peer's subscriptions. Copies of its tuples stay readable for kOwnerGrace.
  virtual void on_peer(const PeerIdentity& peer, PeerEvent event) = 0;
  /// The summary of a component that is up: after kUp unless it is empty, and at each change.
  virtual void on_summary(OwnerId peer, std::string_view summary) = 0;
};

/// Connects the tuple space of one component to those of all others. Outlives the space. All calls are asynchronous and
/// do not block; messages between two components stay in order.
class Link {
 public:
  virtual ~Link() = default;

  /// Begins a start of this component. The listener is not owned; peers that are present already are reported in a
  /// later turn. `incarnation`: PeerIdentity::incarnation of this start. A link that had that number or a higher one
  /// before takes the next number.
  virtual void attach(LinkListener& listener, std::uint64_t incarnation) = 0;
  /// Ends it: all others see that this component left.
  virtual void detach() = 0;

  /// Sends the changes of this turn to a subscriber: each tuple at most once, with its latest value. False: nothing was
  /// sent because the queue is full; try again a little later.
  virtual bool publish(OwnerId subscriber, std::span<const Change> changes) = 0;

  /// Repeating an id replaces that subscription; the owners send its snapshot again.
  virtual void subscribe(const SubscriptionSpec& spec) = 0;
  virtual void unsubscribe(std::uint32_t id) = 0;
  /// kNotFound if no such owner is present, kBusy if the queue is full.
  virtual Result<void> remote_set(const RemoteSet& set) = 0;
  virtual void reply(const Reply& reply) = 0;
  /// The components that are present, by id. An engine may meet only those that this one deals with, and those that
  /// deal with it.
  virtual std::vector<OwnerId> peers() const = 0;
  /// Whether a component that is not among them may be there: it is looked for from now on. False: it is not there.
  virtual bool seeks(OwnerId id) {
    std::ignore = id;
    return false;
  }
  /// Sets the summary that all others receive, at most kMaxSummary bytes. It is kept when the listener changes.
  virtual void describe(std::string summary) = 0;
  /// Calls `visit` with each number that the engine counts since attach(), for metrics; the names (`peis-refused-keys`)
  /// never change.
  virtual void each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const {
    std::ignore = visit;
  }
  /// Lives as long as the link. The space hears only of components that may join.
  virtual PeerPolicy& policy() = 0;
};

/// Makes the links of a process: an engine that was opened.
class Ecology {
 public:
  virtual ~Ecology() = default;
  /// kDuplicate if this process has a component of that id, kIo if the engine cannot make the link.
  virtual Result<std::unique_ptr<Link>> join(OwnerId id) = 0;
};

}  // namespace rubicon::tuples
