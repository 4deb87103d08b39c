#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/link.h"
#include "tuples/peer_policy.h"
#include "tuples/remote_sets.h"

namespace rubicon::tuples::joined {

/// A component as one engine sees it.
struct Meeting {
  PeerIdentity identity;
  SteadyTime since{};
  std::string summary;
  std::map<std::uint32_t, SubscriptionSpec> subscriptions;
  bool left = false;    ///< the component left on the engine where it lived; this engine has not noticed yet
  bool barred = false;  ///< it is not believed to be of this host: it lives nowhere
  Timer conflict;       ///< until the conflict with another component of this id is logged
};

/// What the engines of a joined link see of one id, and the engine where the component with that id lives: messages to
/// it go there. Several meetings with one incarnation are one component; a stand-in of it is used only where
/// the component itself is not met; any other is a rival. Engines are numbered in their order.
class MetPeer {
 public:
  explicit MetPeer(std::size_t engines) : meetings_(engines) {}

  /// What the listener has to be informed of, in this order.
  struct Move {
    std::optional<PeerIdentity> down;
    PeerEvent how = PeerEvent::kLost;
    std::optional<std::size_t> up;  ///< the engine where the component lives now
    bool was_rival = false;         ///< what it sent so far was dropped
  };
  /// An engine met the component; that engine had no meeting before.
  Move meet(std::size_t engine, const PeerIdentity& identity, bool barred = false);
  /// An engine that has a meeting lost the component or saw it leave.
  Move part(std::size_t engine, PeerEvent how);

  Meeting* at(std::size_t engine) { return meetings_[engine] ? &*meetings_[engine] : nullptr; }
  const Meeting* at(std::size_t engine) const { return meetings_[engine] ? &*meetings_[engine] : nullptr; }
  std::optional<std::size_t> home() const { return home_; }
  /// Whether the engine has a meeting with the component that lives here.
  bool is_resident(std::size_t engine) const;
  bool is_forgotten() const;
  /// Another engine that met a different component.
  std::optional<std::size_t> rival_of(std::size_t engine) const;

  /// Takes note that a stream begins. False: the stream is an earlier one that was replaced. A beginning without a time
  /// is one that the engine itself notices (its connection is back): it never takes over from another engine.
  bool begin_stream(std::size_t engine, const Restart& restart);
  /// Whether changes that this engine brings count.
  bool counts(std::size_t engine) const { return !stream_ || stream_->engine == engine; }

 private:
  bool comes_before(std::size_t engine, const PeerIdentity& news) const;
  std::optional<std::size_t> next_home(std::uint64_t incarnation) const;
  Move live_at(std::optional<std::size_t> engine);

  /// The newest stream of changes, by the clock of the component that sends it.
  struct Stream {
    std::size_t engine = 0;
    PeerIdentity sender;
    WallTime since{};
  };

  std::vector<std::optional<Meeting>> meetings_;  ///< by engine
  std::optional<std::size_t> home_;
  std::optional<Stream> stream_;
};

/// Whether `news` is a later start of the component `before`, and not another component: of two starts on one host the
/// earlier one has ended, or will be displaced.
bool is_restart(const PeerIdentity& before, const PeerIdentity& news);

/// Asks the policy of the engine that brought the request. Each engine reports its peers to its own policy.
class JoinedPolicy final : public PeerPolicy {
 public:
  /// The policy of the engine that speaks for the peer at the moment. For kLinkItself: of an engine that observes own
  /// tuples. For kNoOwner: of any engine, if possible one with a judge. nullptr: there is none.
  using Find = std::function<PeerPolicy*(OwnerId peer)>;
  explicit JoinedPolicy(Find find) : find_(std::move(find)) {}

  Result<void> may_join(const PeerIdentity& peer) override {
    auto* policy = find_(peer.id);
    return policy ? policy->may_join(peer) : absent(peer.id);
  }
  void peer_up(const PeerIdentity&) override {}
  void peer_down(OwnerId) override {}
  Result<void> may_subscribe(OwnerId peer, const SubscriptionSpec& spec) override {
    if (peer == kLinkItself) return {};
    auto* policy = find_(peer);
    return policy ? policy->may_subscribe(peer, spec) : absent(peer);
  }
  Result<void> may_set(const RemoteSet& set) override {
    auto* policy = find_(set.from);
    return policy ? policy->may_set(set) : absent(set.from);
  }
  Result<void> may_send(OwnerId peer, std::string_view where) override {
    auto* policy = find_(peer);
    return policy ? policy->may_send(peer, where) : absent(peer);
  }
  void answered(const RemoteSet& set, const Reply& reply) override {
    if (auto* policy = find_(set.from)) policy->answered(set, reply);
  }
  const Member* member(OwnerId peer) const override {
    const auto* policy = find_(peer);
    return policy ? policy->member(peer) : nullptr;
  }
  const Member* asker(const RemoteSet& set) override {
    auto* policy = find_(set.from);
    return policy ? policy->asker(set) : nullptr;
  }
  std::string_view host(OwnerId peer) const override {
    const auto* policy = find_(peer);
    return policy ? policy->host(peer) : std::string_view();
  }
  /// All engines of a process ask the same.
  Judge* judge() override {
    auto* policy = find_(model::kNoOwner);
    return policy ? policy->judge() : nullptr;
  }
  bool filters(OwnerId peer) const override {
    const auto* policy = find_(peer);
    return policy && policy->filters(peer);
  }
  Access access(OwnerId peer, std::string_view key) const override {
    const auto* policy = find_(peer);
    return policy ? policy->access(peer, key) : Access{false, false, Duration(0)};
  }

 private:
  static Result<void> absent(OwnerId peer) {
    return fail(ErrorCode::kNotFound, "component " + std::to_string(number(peer)) + " is not present");
  }

  Find find_;
};

/// One component on several engines: offers its tuples, subscriptions and summary on all of them, and sends to each
/// other component by the engine where that one lives. When it moves to another engine, the listener receives kLost and
/// kUp, so that both sides start again with a snapshot.
class JoinedLink final : public Link {
 public:
  /// Subscriptions of one component on one engine; more are ignored.
  static constexpr std::size_t kMaxSubscriptions = 10'000;
  /// Two components with one id may be one that changes: its restart, or the first contact. Afterwards it is an error.
  static constexpr Duration kContactTime = std::chrono::seconds(5), kRestartTime = std::chrono::seconds(60);
  /// A remote set to a stand-in waits until it was met for this time: another engine may meet the component itself.
  static constexpr Duration kSearchTime = std::chrono::seconds(2);

  struct Engine {
    std::string name;
    std::unique_ptr<Link> link;
  };
  JoinedLink(OwnerId self, std::vector<Engine> engines, Scheduler& scheduler, base::LogSink& log,
             std::string own_host = {});
  ~JoinedLink() override;

  void attach(LinkListener& listener, std::uint64_t incarnation) override;
  void detach() override;
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  bool seeks(std::optional<OwnerId> id) override;
  void describe(std::string summary) override;
  void each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const override;
  PeerPolicy& policy() override { return policy_; }

 private:
  class Port;
  /// A request that is being decided, which its engine brought.
  struct Arriving {
    std::size_t engine = 0;
    OwnerId from{};
  };

  void on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event);
  void on_summary(std::size_t engine, OwnerId id, std::string_view summary);
  void on_changes(std::size_t engine, OwnerId owner, std::span<const Change> changes);
  void on_subscribe(std::size_t engine, OwnerId id, const SubscriptionSpec& spec);
  void on_unsubscribe(std::size_t engine, OwnerId id, std::uint32_t subscription);
  void on_remote_set(std::size_t engine, const RemoteSet& set);
  bool on_reply(std::size_t engine, OwnerId from, const Reply& reply);
  void refuse(std::size_t engine, const RemoteSet& set);

  void meet(std::size_t engine, const PeerIdentity& who);
  void part(std::size_t engine, OwnerId id, PeerEvent how);
  void report(OwnerId id, const MetPeer::Move& move);
  void ask_again(std::size_t engine);
  SteadyTime search_end(OwnerId owner) const;
  void release(OwnerId owner);
  void release_due();
  void watch_conflict(MetPeer& peer, OwnerId id, std::size_t engine);
  bool is_barred(std::size_t engine, const PeerIdentity& who) const;
  void log_barred(OwnerId id, std::size_t engine);
  void log_conflict(OwnerId id, std::size_t engine);
  std::string described(OwnerId id, std::size_t engine) const;

  MetPeer* find(OwnerId id);
  Meeting* find(OwnerId id, std::size_t engine);
  bool publish_to_observers(std::span<const Change> changes);
  Link* link_to(OwnerId id);
  PeerPolicy* any_policy();
  std::optional<std::size_t> home_of(OwnerId id) const;

  OwnerId self_;
  Scheduler& scheduler_;
  base::LimitedLog log_;
  std::string own_host_;
  std::vector<std::unique_ptr<Port>> ports_;
  JoinedPolicy policy_;
  LinkListener* listener_ = nullptr;
  std::uint64_t incarnation_ = 0;
  std::uint64_t attachment_ = 0;  ///< changes with the listener, which each call to it may detach
  std::map<OwnerId, MetPeer> peers_;
  std::map<std::uint32_t, SubscriptionSpec> subscriptions_;  ///< own ones
  std::optional<Arriving> arriving_;
  HeldSets held_;
  base::Deadline next_held_{scheduler_, [this] { release_due(); }};
  std::set<std::size_t> observers_;  ///< engines whose links subscribed to own tuples for themselves
  std::set<std::tuple<OwnerId, std::uint64_t, std::uint64_t>> logged_;  ///< conflicts, by the starts of both sides
};

}  // namespace rubicon::tuples::joined
