#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>
#include <vector>

#include "rubicon/summary.hpp"
#include "rubicon/tuple.hpp"
#include "tuples/judge.h"

namespace rubicon::tuples {

/// The owner set a tuple; `tuple.owner` is the sender.
struct TupleSet {
  TupleView tuple;
};

/// A tuple was deleted or expired.
struct TupleGone {
  EventKind how = EventKind::kDeleted;  ///< kDeleted or kExpired
  std::string_view key;
  std::uint64_t sequence = 0;
};

/// All tuples that the subscription covers have been sent. Copies that were not among them no longer exist.
struct SnapshotEnd {
  std::uint32_t subscription = 0;  ///< SubscriptionSpec::id
};

/// The sender had lost this subscriber: what follows replaces what was sent before, whatever its sequence.
struct Restart {
  /// When that began, by the clock of the sender; later than in each Restart before. Orders the streams of one sender
  /// that arrive over several engines. Zero = not given.
  WallTime since{};
};

/// What an owner sends to a subscriber, in order. The views are valid during the call that passes it.
using Change = std::variant<TupleSet, TupleGone, SnapshotEnd, Restart>;

/// Bytes of the texts in it.
inline std::size_t text_size(const Change& change) {
  if (const auto* set = std::get_if<TupleSet>(&change))
    return set->tuple.key.size() + set->tuple.value.size() + set->tuple.media_type.size();
  const auto* gone = std::get_if<TupleGone>(&change);
  return gone ? gone->key.size() : 0;
}

/// A Change that owns its texts.
class OwnedChange {
 public:
  explicit OwnedChange(const Change& change) : change_(change) {
    if (const auto* set = std::get_if<TupleSet>(&change)) {
      key_ = set->tuple.key;
      value_ = set->tuple.value;
      media_type_ = set->tuple.media_type;
    } else if (const auto* gone = std::get_if<TupleGone>(&change)) {
      key_ = gone->key;
    }
  }

  /// Valid while this lives.
  Change view() const {
    auto change = change_;
    if (auto* set = std::get_if<TupleSet>(&change)) {
      set->tuple.key = key_;
      set->tuple.value = value_;
      set->tuple.media_type = media_type_;
    } else if (auto* gone = std::get_if<TupleGone>(&change)) {
      gone->key = key_;
    }
    return change;
  }

  /// Of a set or a deletion; else empty.
  const std::string& key() const { return key_; }

 private:
  Change change_;
  std::string key_, value_, media_type_;
};

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

/// The subscriber as which a link itself subscribes to own tuples: some engines have to know all of them. No component
/// has this id.
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
  /// The components that are present, by id. An engine need not meet all: those that exchange nothing with this one may
  /// be absent from the list.
  virtual std::vector<OwnerId> peers() const = 0;
  /// Whether a component that is not among them may be there: it is looked for from now on. False: it is not there.
  /// nullopt: any component; also false while the engine cannot look.
  virtual bool seeks(std::optional<OwnerId> id) {
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

/// An opened engine: makes the links of a process.
class Ecology {
 public:
  virtual ~Ecology() = default;
  /// kDuplicate if this process has a component of that id, kIo if the engine cannot make the link.
  virtual Result<std::unique_ptr<Link>> join(OwnerId id) = 0;
};

/// A component on an engine in place of one that is on another engine only (docs/decisions/022-two-engines.md).
struct StandIn {
  OwnerId id{};      ///< of the component
  std::string host;  ///< shown as PeerIdentity::host; see marked_host()
  /// Called in a later turn: another presence uses the id on this engine. The stand-in should end.
  std::function<void()> displaced;
};

/// An engine that stand-ins can join.
class StandInEcology : public Ecology {
 public:
  /// As join().
  virtual Result<std::unique_ptr<Link>> join_as(StandIn who) = 0;
  /// False: components on this engine ignore a stand-in of this carrier for this id.
  virtual bool may_stand_in(OwnerId /*carrier*/, OwnerId /*id*/) const { return true; }
};

/// The host of a component, as its stand-in shows it: `<host>~<id of the carrier>`, at most 64 bytes.
std::string marked_host(std::string_view host, OwnerId carrier);
/// kNoOwner: the host has no mark, so its component is not a stand-in.
OwnerId carrier_of(std::string_view host);
inline bool is_stand_in(const PeerIdentity& peer) {
  return carrier_of(peer.host) != model::kNoOwner;
}
/// The host without a mark.
std::string_view real_host(std::string_view host);

}  // namespace rubicon::tuples
