#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "rubicon/summary.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::base {
class Scheduler;
}

namespace rubicon::tuples {

class Link;
struct SpaceRights;

/// Refers to one own tuple, for writing it often without a search by key. Valid until the tuple is deleted or expires;
/// then every use fails with kNotFound, because the generation differs.
struct TupleRef {
  std::uint32_t index = 0xffffffff;
  std::uint32_t generation = 0;

  friend bool operator==(const TupleRef&, const TupleRef&) = default;
};

/// The demand for one own tuple began, ended, or changed its pace.
struct Demand {
  TupleRef tuple;
  std::string_view key;
  bool wanted = false;   ///< at least one active (not passive) subscription of any component, including this one
  Duration interval{0};  ///< shortest minimum interval of all active subscriptions; zero = one of them gives none
  Duration named{0};     ///< shortest minimum interval among those that give one; zero = none does
};
using DemandCall = std::function<void(const Demand&)>;
using PeerCall = std::function<void(OwnerId peer, PeerEvent event)>;
using SummaryCall = std::function<void(OwnerId peer, std::string_view summary)>;
/// All tuples of this owner that the subscription covers have arrived: get() and list() see them.
using SnapshotCall = std::function<void(OwnerId owner)>;

/// How long copies stay readable after their owner left or was lost. An owner is lost when nothing is heard from it for
/// its lease (2 s by default, at most 15 s): copies end less than a minute after its last sign of life.
inline constexpr Duration kOwnerGrace = std::chrono::seconds(45);

/// Keeps a subscription, a watch or a policy alive; destroying it, or reset(), ends that. May outlive the space.
class Handle {
 public:
  Handle() = default;
  explicit Handle(std::function<void()> end) : end_(std::move(end)) {}
  Handle(Handle&& other) noexcept : end_(std::exchange(other.end_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { reset(); }
  void reset();
  explicit operator bool() const { return static_cast<bool>(end_); }

 private:
  std::function<void()> end_;
};

/// A component's view of the tuple space: the tuples it owns, and cached copies of those it subscribes to. Callbacks
/// run in a later turn of the loop, never inside a call, in the order of the sets. A local subscriber receives each
/// set, a distant one the latest of each turn (docs/decisions). Not thread-safe. The scheduler and the link must
/// outlive it.
///
/// A pattern that Pattern::parse() would reject gives an empty Handle.
class TupleSpace final {
 public:
  TupleSpace(OwnerId self, base::Scheduler& scheduler, Link& link);
  ~TupleSpace();

  OwnerId self() const;

  // -- own tuples
  /// Sets the tuple unless it exists.
  Result<TupleRef> declare(std::string_view key, std::string_view value = {}, const SetOptions& options = {});
  /// Creates or changes the tuple. kInvalid for a bad key, kOutOfRange for a value beyond 1 MiB, kRefused if the tuple
  /// does not have the expected sequence.
  Result<TupleRef> set(std::string_view key, std::string_view value, const SetOptions& options = {});
  Result<void> set(TupleRef tuple, std::string_view value, const SetOptions& options = {});
  /// Appends bytes to the value of an own tuple. It counts as one set: the sequence grows by 1, and subscribers receive
  /// the whole value. Fails without a change: kNotFound if there is no such tuple, kInvalid if `options` give a media
  /// type other than the tuple's (empty = any), kOutOfRange if the value would exceed 1 MiB, kRefused if the tuple does
  /// not have the expected sequence. Without a lifetime in `options` the expiry stays as it was.
  Result<void> append(std::string_view key, std::string_view bytes, const SetOptions& options = {});
  Result<void> append(TupleRef tuple, std::string_view bytes, const SetOptions& options = {});
  /// Deletes an own tuple; kNotFound if there is none.
  Result<void> erase(std::string_view key);
  /// Deletes all own tuples that match, over several turns if they are many. Does nothing if the pattern names another
  /// owner.
  void erase(const Pattern& pattern);
  std::optional<TupleRef> find(std::string_view key) const;
  /// Whether the tuple has at least one subscriber, active or passive.
  bool has_subscriber(TupleRef tuple) const;

  /// Reports each begin, change and end of demand for own tuples that match, present and future ones. Begins with those
  /// that are in demand now, in a later turn. Changes within a turn are merged.
  [[nodiscard]] Handle watch_demand(const Pattern& pattern, DemandCall call);

  /// Makes `policy` decide about remote sets of own tuples that match; of several policies the one with the narrowest
  /// pattern decides. Without a policy remote sets are refused. Requests that fail for another reason (sequence, size,
  /// media type, an append outside `scope`) are refused before the policy is called.
  [[nodiscard]] Handle add_policy(const Pattern& pattern, SetPolicy policy, PolicyScope scope = PolicyScope::kSets);

  // -- tuples of all components
  /// Delivers all present tuples that match, from a later turn on, then every change. `snapshot` is called for each
  /// other owner once all its tuples have been delivered, and again each time the owner returns.
  [[nodiscard]] Handle subscribe(const Pattern& pattern, const Flow& flow, EventCall call, SnapshotCall snapshot = {});

  /// Asks the owner, which may be this component, to set its tuple. `call` receives exactly one reply, in a later turn;
  /// kTimedOut if there is none within the time to live (zero = 5 s). Returns the number of the request.
  std::uint64_t set_remote(OwnerId owner, std::string_view key, std::string_view value, Duration time_to_live,
                           ReplyCall call, const SetOptions& options = {});

  /// Asks the owner to append, under the rules of append() and of its policy. If the reply is lost, it is not known
  /// whether the bytes were appended: give the expected sequence, and repeating is safe.
  std::uint64_t append_remote(OwnerId owner, std::string_view key, std::string_view bytes, Duration time_to_live,
                              ReplyCall call, const SetOptions& options = {});

  /// An own tuple, or the cached copy of another component's. The views are valid until the next call or turn.
  std::optional<TupleView> get(OwnerId owner, std::string_view key) const;
  /// Visits own tuples and cached copies that match, in no particular order.
  void list(const Pattern& pattern, const std::function<void(const TupleView&)>& visit) const;

  // -- components
  /// The other components that are present, by id.
  std::vector<OwnerId> peers() const;
  /// Reports components that appear, leave or are lost from now on.
  [[nodiscard]] Handle watch_peers(PeerCall call);
  /// Publishes a summary of this component, which all others receive without subscribing (docs/ecology.md). kOutOfRange
  /// if it is longer than kMaxSummary.
  Result<void> describe(std::string_view summary);
  /// The summary of a component that is present; empty = it published none. Valid until the next turn.
  std::string_view summary(OwnerId peer) const;
  /// Reports each change of a summary.
  [[nodiscard]] Handle watch_summaries(SummaryCall call);

  /// Present sizes, and counters since the start, for metrics.
  struct Stats {
    std::size_t own = 0, cached = 0, subscriptions = 0;
    std::size_t queued = 0;     ///< events for local subscribers and changes for peers that wait for delivery
    std::uint64_t sets = 0;     ///< sets and appends of own tuples
    std::uint64_t events = 0;   ///< events delivered to local subscribers
    std::uint64_t merged = 0;   ///< changes replaced by a later one before delivery
    std::uint64_t dropped = 0;  ///< changes and subscriptions beyond a limit, or invalid ones
    std::uint64_t refused = 0;  ///< subscriptions and remote sets of peers that the link's PeerPolicy refused
  };
  Stats stats() const;

 private:
  friend struct SpaceRights;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::tuples

namespace rubicon {
using tuples::Handle;
using tuples::TupleSpace;
}  // namespace rubicon
