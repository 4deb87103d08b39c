#pragma once

#include <deque>
#include <map>
#include <set>

#include "base/scheduler.h"
#include "tuples/deadlines.h"
#include "tuples/event_queue.h"
#include "tuples/link.h"
#include "tuples/outbox.h"
#include "tuples/remote_sets.h"

namespace rubicon::tuples {

inline constexpr std::size_t kMaxValueSize = 1024UL * 1024;
/// Copies of foreign tuples one component keeps; more are dropped and counted.
inline constexpr std::size_t kMaxCached = 2'000'000;
/// Subscriptions one distant component may hold here.
inline constexpr std::size_t kMaxSubscriptionsPerPeer = 10'000;
static_assert(2 * kMaxSubscriptionsPerPeer <= Outbox::kMaxControls);

/// An operation on all tuples that match a pattern, done in slices of some nodes per turn.
struct Walk {
  enum class Purpose { kJoin, kLeave, kErase, kReconcile, kForget, kRejudge };

  Walk(Purpose why, PartTrie& trie, const Pattern& p, SubscriptionPtr s, std::uint32_t g)
      : purpose(why), pattern(p), subscription(std::move(s)), generation(g), steps(trie, p) {}

  /// Whether the tuple existed when the walk began. Generations may wrap around.
  bool is_older(const Tuple& tuple) const { return static_cast<std::int32_t>(tuple.generation - generation) <= 0; }

  Purpose purpose;
  Pattern pattern;
  SubscriptionPtr subscription;
  std::uint32_t generation;  ///< of the youngest tuple when the walk began
  PatternWalk steps;
};

/// Everything that happens in one turn of the loop is reported at its end: one posted call makes the callbacks, reports
/// demand and passes changes to the link.
struct TupleSpace::Impl final : LinkListener {
  Impl(OwnerId id, Scheduler& sched, Link& far);
  void on_changes(OwnerId owner, std::span<const Change> changes) override;
  void on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) override;
  void on_unsubscribe(OwnerId subscriber, std::uint32_t id) override;
  void on_remote_set(const RemoteSet& set) override;
  bool on_reply(OwnerId from, const Reply& reply) override;
  void on_peer(const PeerIdentity& peer, PeerEvent event) override;
  void on_summary(OwnerId peer, std::string_view summary) override;

  // -- turns
  void open_turn();
  void end_turn();
  void flush_outbox();
  template <class Call>
  void later(Call call) {
    lifetime.post(scheduler, std::move(call));
  }
  /// A Handle whose end does nothing after the space was destroyed.
  template <class End>
  Handle handle(End end) {
    return Handle(lifetime.guard(std::move(end)));
  }

  // -- tuples
  std::uint32_t find(OwnerId owner, std::string_view key);
  bool pending_erase(std::uint32_t index) const;
  Result<TupleRef> write(std::string_view key, std::string_view value, const SetOptions& options, OwnerId creator);
  void write(std::uint32_t index, std::string_view value, const SetOptions& options, OwnerId creator);
  Result<TupleRef> append(std::string_view key, std::string_view bytes, const SetOptions& options, OwnerId creator);
  Result<void> check_sequence(std::string_view key, std::uint32_t index, const SetOptions& options) const;
  Result<void> check_append(std::string_view key, std::uint32_t index, std::size_t more,
                            const SetOptions& options) const;
  void stamp(Tuple& tuple, const SetOptions& options, OwnerId creator);
  void live_for(std::uint32_t index, Duration lifetime);
  void set_media_type(Tuple& tuple, std::string_view name);
  void announce(std::uint32_t index, EventKind kind);
  void deliver(const SubscriptionPtr& subscription, std::uint32_t index, EventKind kind);
  void pace(Subscription& subscription, std::uint32_t index, EventKind kind);
  void remove(std::uint32_t index, EventKind how);
  void on_deadline(const Deadline& deadline, SteadyTime now);
  bool still_matters(const Deadline& deadline) const;

  // -- subscriptions
  SubscriptionPtr subscribe(const Pattern& pattern, const Flow& flow, EventCall call, std::shared_ptr<PeerQueue> peer,
                            std::uint32_t wire_id);
  void unsubscribe(const SubscriptionPtr& subscription);
  void walk(Walk::Purpose purpose, const Pattern& pattern, SubscriptionPtr subscription);
  bool resume(Walk& walk);
  void visit(Walk& walk, std::uint32_t index);
  void join(const SubscriptionPtr& subscription, std::uint32_t index);
  void leave(const SubscriptionPtr& subscription, std::uint32_t index);
  void run_walks();

  // -- rights of others (space_rights.cpp)
  SubscriptionPtr judged(const SubscriptionPtr& subscription, std::string_view key);
  SubscriptionPtr add_variant(Subscription& subscription, const Flow& flow);
  void settle(const SubscriptionPtr& subscription, std::uint32_t index);
  void take_away(const SubscriptionPtr& subscription, std::uint32_t index);
  void restart_stream(OwnerId peer);
  void rejudge();
  void end_rejudge(Subscription& subscription);
  std::uint32_t free_wire_id();

  // -- other components (space_distant.cpp)
  void apply(OwnerId owner, const TupleSet& change);
  void apply(OwnerId owner, const TupleGone& change);
  void apply(OwnerId owner, const SnapshotEnd& end);
  void apply(OwnerId owner, const Restart&) { begin_epoch(owner); }
  void update_copy(std::uint32_t index, const TupleView& news);
  void drop_peer(OwnerId peer);
  bool has(const PeerQueue& peer, std::uint32_t subscription) const;
  void peer_up(OwnerId owner);
  void begin_epoch(OwnerId owner);
  Restart next_restart();
  void peer_down(OwnerId owner);
  std::uint64_t start_request(RemoteSet&& set, ReplyCall call);
  void send(RemoteSet&& set);
  void refuse(const RemoteSet& set, const Error& why);
  void hold(const RemoteSet& set);
  void release_sought();
  static Result<void> check_sizes(const RemoteSet& set);
  void refuse_unsound(const RemoteSet& set, const Error& why);
  SetDecision decide(const RemoteSet& set);
  /// `meant`: SetDecision::meant.
  Reply answer(const RemoteSet& set, std::shared_ptr<const RemoteSet>& meant);
  void answer_own(RemoteSet set);

  OwnerId self;
  Scheduler& scheduler;
  Link& link;

  Store store;
  EventQueue queue;
  Outbox outbox;
  DemandWatches demand;
  Deadlines deadlines;
  Expiry expiry;
  Pacer pacer;
  Requests requests;
  HeldSets sought;  // whose owners the link looks for
  Duration seek_step{};
  base::Deadline sought_due{scheduler, [this] { release_sought(); }};
  SetPolicies policies;

  struct Peer {
    std::shared_ptr<PeerQueue> outgoing;
    std::unordered_map<std::uint32_t, SubscriptionPtr> subscriptions;
  };
  std::map<OwnerId, Peer> subscribers;      // distant ones
  std::map<OwnerId, std::uint16_t> epochs;  // incremented when an owner comes up or restarts
  std::map<OwnerId, Timer> absent;          // owners that left or were lost, and the end of their grace
  std::map<OwnerId, std::string> summaries;
  std::vector<std::shared_ptr<PeerCall>> peer_calls;
  std::vector<std::shared_ptr<SummaryCall>> summary_calls;

  std::unordered_map<std::uint64_t, SubscriptionPtr> by_number;
  std::unordered_map<std::uint32_t, SubscriptionPtr> by_wire_id;  // local ones
  std::uint64_t last_number = 0;
  std::uint32_t last_wire_id = 0;
  std::deque<std::unique_ptr<Walk>> walks;
  std::size_t erasing = 0;  // walks that erase
  std::size_t walk_budget = 0;

  bool turn_is_open = false;
  bool turn_is_ending = false;  // end_turn() runs: a turn that opens now needs no posted call
  SteadyTime now{};
  WallTime wall{};
  WallTime last_restart{};
  Timer outbox_retry;
  std::uint64_t sets = 0;
  std::uint64_t dropped = 0;
  std::uint64_t refused = 0;  // by the link's policy
  base::Lifetime lifetime;    // last: ends first
};

/// Whether the pattern is valid. To be asked of each pattern that this space did not parse itself.
bool is_sound(const Pattern& pattern);

}  // namespace rubicon::tuples
