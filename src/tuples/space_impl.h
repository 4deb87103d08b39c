#pragma once

#include <deque>
#include <map>
#include <set>

#include "tuples/deadlines.h"
#include "tuples/demand_watches.h"
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

/// A long walk over the tuples, done some nodes a turn.
struct Walk {
  enum class Aim { kJoin, kLeave, kErase, kReconcile, kForget };

  Walk(Aim a, PartTrie& trie, const Pattern& p, SubscriptionPtr s, std::uint32_t g)
      : aim(a), pattern(p), subscription(std::move(s)), generation(g), steps(trie, p) {}

  /// Was there when the walk began. Generations may wrap around.
  bool is_older(const Tuple& tuple) const { return static_cast<std::int32_t>(tuple.generation - generation) <= 0; }

  Aim aim;
  Pattern pattern;
  SubscriptionPtr subscription;
  std::uint32_t generation;  ///< of the youngest tuple when the walk began
  PatternWalk steps;
};

/// What TupleSpace is made of. Everything that happens in one turn of the loop is told at its end: one posted call
/// makes the callbacks, tells demand and hands changes to the link.
struct TupleSpace::Impl final : LinkListener {
  Impl(OwnerId id, Scheduler& sched, Link& far);
  ~Impl() override;

  void on_changes(OwnerId owner, std::span<const Change> changes) override;
  void on_subscribe(OwnerId subscriber, const SubscriptionSpec& spec) override;
  void on_unsubscribe(OwnerId subscriber, std::uint32_t id) override;
  void on_remote_set(const RemoteSet& wish) override;
  void on_reply(const Reply& reply) override;
  void on_peer(OwnerId peer, PeerEvent event) override;
  void on_summary(OwnerId peer, std::string_view summary) override;

  // -- turns
  void open_turn();
  void end_turn();
  void flush_outbox();
  template <class Call>
  void later(Call call) {
    scheduler.post([door = std::weak_ptr<Impl*>(door), call = std::move(call)] {
      if (door.lock()) call();
    });
  }
  /// A Handle whose end does nothing once the space is gone.
  template <class End>
  Handle handle(End end) {
    return Handle([door = std::weak_ptr<Impl*>(door), end = std::move(end)] {
      if (door.lock()) end();
    });
  }

  // -- tuples
  std::uint32_t find(OwnerId owner, std::string_view key);
  bool condemned(std::uint32_t index) const;
  Result<TupleRef> write(std::string_view key, std::string_view value, const SetOptions& options, OwnerId creator);
  void write(std::uint32_t index, std::string_view value, const SetOptions& options, OwnerId creator);
  Result<TupleRef> append(std::string_view key, std::string_view bytes, const SetOptions& options, OwnerId creator);
  Result<void> check_sequence(std::string_view key, std::uint32_t index, const SetOptions& options) const;
  Result<void> check_append(std::string_view key, std::uint32_t index, std::size_t more,
                            const SetOptions& options) const;
  void stamp(Tuple& tuple, const SetOptions& options, OwnerId creator);
  void live_for(Tuple& tuple, std::uint32_t index, Duration lifetime);
  void set_media_type(Tuple& tuple, std::string_view name);
  void announce(std::uint32_t index, EventKind kind);
  void deliver(const SubscriptionPtr& subscription, std::uint32_t index, EventKind kind);
  void pace(Subscription& subscription, std::uint32_t index, EventKind kind);
  void remove(std::uint32_t index, EventKind how);
  void on_deadline(const Deadline& deadline, SteadyTime now);
  bool still_matters(const Deadline& deadline) const;

  // -- subscriptions
  SubscriptionPtr subscribe(const Pattern& pattern, const Flow& flow, EventCall call, std::shared_ptr<PeerBox> peer,
                            std::uint32_t wire_id);
  void unsubscribe(const SubscriptionPtr& subscription);
  void walk(Walk::Aim aim, const Pattern& pattern, SubscriptionPtr subscription);
  bool go_on(Walk& walk);
  void step(Walk& walk, std::uint32_t index);
  void join(const SubscriptionPtr& subscription, std::uint32_t index);
  void leave(const SubscriptionPtr& subscription, std::uint32_t index);
  void run_walks();
  std::uint32_t free_wire_id();

  // -- others
  void take_change(OwnerId owner, const Change& change);
  void take_value(std::uint32_t index, const Change& change);
  void drop_peer(OwnerId peer);
  void end_snapshot(OwnerId owner, std::uint32_t wire_id);
  void came(OwnerId owner);
  void confirm_anew(OwnerId owner);
  void went(OwnerId owner);
  std::uint64_t ask(RemoteSet wish, ReplyCall call);
  void send(RemoteSet wish);
  SetDecision decide(const RemoteSet& wish);
  Reply judge(const RemoteSet& wish);
  void judge_own(RemoteSet wish);

  OwnerId self;
  Scheduler& scheduler;
  Link& link;
  std::shared_ptr<Impl*> door = std::make_shared<Impl*>(this);

  Store store;
  EventQueue queue;
  Outbox outbox;
  DemandWatches demand;
  Deadlines deadlines;
  Expiry expiry;
  Pacer pacer;
  Requests requests;
  SetPolicies policies;

  struct Peer {
    std::shared_ptr<PeerBox> box;
    std::unordered_map<std::uint32_t, SubscriptionPtr> subscriptions;
  };
  std::map<OwnerId, Peer> subscribers;      // distant ones
  std::map<OwnerId, std::uint16_t> epochs;  // how often an owner came up
  std::map<OwnerId, Timer> absent;          // owners that were lost or left and are not back; ends their grace
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
  bool turn_is_ending = false;  // what opens a turn now is told before the end is over
  SteadyTime now{};
  WallTime wall{};
  Timer outbox_retry;
  std::uint64_t sets = 0;
  std::uint64_t dropped = 0;
  std::uint64_t refused = 0;  ///< by the link's policy
};

/// Keys of patterns built by hand or sent by others are checked before anything walks by them.
bool is_sound(const Pattern& pattern);

}  // namespace rubicon::tuples
