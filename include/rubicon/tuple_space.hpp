#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "rubicon/tuple.hpp"

namespace rubicon::base {
class Scheduler;
}

namespace rubicon::tuples {

class Link;

/// Short name of one own tuple, for those who set it often. Valid until the tuple is deleted or expires; a stale one is
/// recognised (generation) and answered with kNotFound.
struct TupleRef {
  std::uint32_t index = 0xffffffff;
  std::uint32_t generation = 0;

  friend bool operator==(const TupleRef&, const TupleRef&) = default;
};

/// Somebody began or ceased to want one of our tuples, or wants it at another pace.
struct Demand {
  TupleRef tuple;
  std::string_view key;
  bool wanted = false;   ///< at least one active (not passive) subscription of any component, own ones included
  Duration interval{0};  ///< shortest wanted minimum interval; zero = at least one subscriber named none
  Duration named{0};     ///< shortest interval that was named; zero = nobody named one
};
using DemandCall = std::function<void(const Demand&)>;
using PeerCall = std::function<void(OwnerId peer, PeerEvent event)>;
using SummaryCall = std::function<void(OwnerId peer, std::string_view summary)>;
/// The tuples of this owner that a subscription covers are all here: get() and list() see them.
using SnapshotCall = std::function<void(OwnerId owner)>;

/// How long copies stay readable whose owner left or was lost. With the lease after which it is lost (2 s if not
/// configured, at most 15 s) that is less than a minute after its last sign of life.
inline constexpr Duration kOwnerGrace = std::chrono::seconds(45);

class TupleSpace;

/// Ends what it stands for when destroyed: a subscription, a watch, a judge. May outlive the space.
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

/// One component's door to the ecology: its own tuples, of which it is the authority, and copies of what it subscribed
/// to. Callbacks come in a later turn, never from inside a call, in the order of the sets; a local subscriber
/// sees each set, a distant one the latest of a turn (docs/decisions). One thread. Scheduler and link must outlive it.
class TupleSpace final {
 public:
  TupleSpace(OwnerId self, base::Scheduler& scheduler, Link& link);
  ~TupleSpace();

  OwnerId self() const;

  // -- own tuples
  /// Makes the tuple (empty value, published like any set) if it is not there.
  Result<TupleRef> declare(std::string_view key, std::string_view value = {}, const SetOptions& options = {});
  Result<TupleRef> set(std::string_view key, std::string_view value, const SetOptions& options = {});
  Result<void> set(TupleRef tuple, std::string_view value, const SetOptions& options = {});
  /// Adds bytes behind the value of an own tuple, as one set: sequence +1, everybody sees the whole value. kNotFound
  /// when there is none, kInvalid when `options` name another media type than it has (empty = whatever it has),
  /// kOutOfRange beyond 1 MiB, kRefused when it has not the expected sequence; the tuple is then unchanged. Without a
  /// lifetime it expires when it would have.
  Result<void> append(std::string_view key, std::string_view bytes, const SetOptions& options = {});
  Result<void> append(TupleRef tuple, std::string_view bytes, const SetOptions& options = {});
  Result<void> erase(std::string_view key);
  /// Deletes own tuples; long walks take several turns. Only keys count, an owner in the pattern must be self.
  void erase(const Pattern& pattern);
  std::optional<TupleRef> find(std::string_view key) const;
  /// The tuple has at least one subscriber, passive ones included.
  bool has_subscriber(TupleRef tuple) const;

  /// First and last active subscriber of each own tuple that matches, present and future; the present wanted ones are
  /// told at once (in a later turn). Changes within a turn are merged.
  [[nodiscard]] Handle watch_demand(const Pattern& pattern, DemandCall call);

  /// Decides about remote sets on own keys that match; the narrowest pattern wins. Without one they are refused, and
  /// appends are unless it accepts them. What cannot be done anyway (sequence, size, media type) does not reach it.
  [[nodiscard]] Handle add_policy(const Pattern& pattern, SetPolicy policy, PolicyScope scope = PolicyScope::kSets);

  // -- everybody's tuples
  /// Present matching tuples are told at once (in a later turn), then every change. `snapshot` is told once for each
  /// other owner, and again when it was away.
  [[nodiscard]] Handle subscribe(const Pattern& pattern, const Flow& flow, EventCall call, SnapshotCall snapshot = {});

  /// Asks the owner (self is fine) to set its tuple; the answer comes exactly once, in a later turn: at the latest when
  /// the time to live ends, kExpired. `time_to_live` zero = 5 s.
  std::uint64_t set_remote(OwnerId owner, std::string_view key, std::string_view value, Duration time_to_live,
                           ReplyCall call, const SetOptions& options = {});

  /// Asks the owner to append, under the rules of append() and its judge. An answer that is lost leaves open whether
  /// the bytes were added: who repeats it names the expected sequence.
  std::uint64_t append_remote(OwnerId owner, std::string_view key, std::string_view bytes, Duration time_to_live,
                              ReplyCall call, const SetOptions& options = {});

  /// Own tuple, or copy of a foreign one that a subscription of ours covers.
  std::optional<TupleView> get(OwnerId owner, std::string_view key) const;
  void list(const Pattern& pattern, const std::function<void(const TupleView&)>& visit) const;

  // -- components
  std::vector<OwnerId> peers() const;
  [[nodiscard]] Handle watch_peers(PeerCall call);
  /// What all others see of this component without subscribing (docs/ecology.md); kOutOfRange beyond kMaxSummary.
  Result<void> describe(std::string_view summary);
  /// What a present component says of itself; empty = nothing. Valid until the next turn.
  std::string_view summary(OwnerId peer) const;
  /// Told when a component says something else of itself than before.
  [[nodiscard]] Handle watch_summaries(SummaryCall call);

  /// Numbers for people and metrics: tuples own and cached, subscriptions, events queued, merged for slow peers.
  struct Stats {
    std::size_t own = 0, cached = 0, subscriptions = 0, queued = 0;
    std::uint64_t sets = 0, events = 0, merged = 0, dropped = 0;
    std::uint64_t refused = 0;  ///< subscriptions and remote sets of others that the policy of the link did not take
  };
  Stats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::tuples

namespace rubicon {
using tuples::Handle;
using tuples::TupleSpace;
}  // namespace rubicon
